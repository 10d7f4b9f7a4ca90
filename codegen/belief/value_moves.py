# SPDX-License-Identifier: Apache-2.0
"""Values of fixed state that particles move one by one (``value_moves.hpp``)."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.codegen.belief.redraw import place_of
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.layout.state_layout import pack
from hypgen.codegen.model.interface import NOTHING, PLACE, WEIGHT, Interface
from hypgen.codegen.model.model_functions import arguments, density, density_needs
from hypgen.codegen.tree.expr import Expr, Literal, call, cast, not_, number, of, op, shifted
from hypgen.codegen.tree.statements import Function, Return, Statement, assign, const, when
from hypgen.dsl import ir
from hypgen.dsl.types import size_of


class ValueMoves:
    """Prints what moves the values of one model's hidden variables."""

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        self.context = interface.context
        self.model = interface.model
        self.inits = [a for a in self.model.inits if not self.model.variable(a.variable).visible]
        unique = self.context.names.struct.unique
        self.densities = {a.variable: unique(f"density_init_{a.variable}") for a in self.inits}
        hidden = {a.variable for a in self.inits}
        self.fields = [f for f in pack(self.model).fixed.fields if f.variable in hidden and f.width]

    def constants(self) -> list[str]:
        """Return how many values may move."""
        return [f"static constexpr int kHiddenValues = {sum(f.length for f in self.fields)};"]

    def density_functions(self) -> list[Function]:
        """Return the densities of the hidden variables' inits."""
        variable = self.model.variable
        return [
            density(a, variable(a.variable).type, self.densities[a.variable], self.context)
            for a in self.inits
        ]

    def all(self) -> list[Function]:
        """Return what the runtime calls."""
        return [self._size(), self._value(), self._put(), self._init_density(), self.interface.weigh_hidden()]

    def _size(self) -> Function:
        builder = self.interface.given([("int", "entry")])
        self._choose(builder, [Return(number(size_of(f.type))) for f in self.fields])
        comment = ["// How many values an entry of a hidden variable may have."]
        return builder.done("std::int32_t", "hidden_size", comment)

    def _value(self) -> Function:
        builder = self.interface.given([("const Fixed&", "fixed"), ("int", "entry")])
        gets = [call("bits::get", *place) for place in self._places()]
        self._choose(builder, [Return(cast("std::int32_t", get)) for get in gets])
        return builder.done("std::int32_t", "hidden_value", ["// Such a value, numbered from 0."])

    def _put(self) -> Function:
        builder = self.interface.given([("Fixed&", "fixed"), ("int", "entry"), ("std::int32_t", "value")])
        value, puts = cast("std::uint32_t", "value"), []
        for word, shift, width in self._places():
            puts.append(assign(word, call("bits::put", word, shift, width, value)))
        self._choose(builder, puts, ends=False)
        return builder.done("void", "put_hidden")

    def _choose(self, builder: Builder, statements: Sequence[Statement], ends: bool = True) -> None:
        """Append one statement for each field, under the condition that the entry is the field's."""
        end = 0
        for place, (field, statement) in enumerate(zip(self.fields, statements, strict=True)):
            end += field.length
            test, last = op("entry", "<", end), place == len(statements) - 1
            if ends or not place:
                builder.code.add(statement if last else when(test, statement))
                continue
            with builder.code.otherwise() if last else builder.code.or_when(test):
                builder.code.add(statement)

    def _places(self) -> list[tuple[Expr, Expr, Expr]]:
        """Return word, shift and width of the entry at hand, for each field."""
        found, start = [], 0
        for field in self.fields:
            word, shift = place_of(field, shifted("entry", -start))
            if field.length > 1:
                shift = cast("std::uint32_t", shift)
            found.append((word, shift, number(field.width)))
            start += field.length
        return found

    def _init_density(self) -> Function:
        builder = self.interface.given(PLACE)
        for init in self.inits:
            self._refuse_outside(builder, init)
        builder.code.add(WEIGHT)
        for init in self.inits:
            needs = density_needs(init.dist, self.context)
            with builder.printer.loops(init.binders):
                read = _read(self.model.variable(init.variable), init.binders)
                more = builder.printer.exprs((*read.indices, read))
                density = call(self.densities[init.variable], *arguments(needs, self.context, *more))
                builder.code.add(assign("weight", density, "*="))
                builder.code.add(when(not_(op("weight", ">", Literal("0.0"))), NOTHING))
        builder.code.add(Return(of("weight")))
        comment = ["// The probability of the hidden values at the start."]
        return builder.done("double", "init_density", comment)

    def _refuse_outside(self, builder: Builder, init: ir.Assign) -> None:
        """Append what spares counting a set that a value is not in. An empty set may have its first value."""
        dist = init.dist
        if not isinstance(dist, ir.UniformSet) or dist.condition is None or dist.otherwise is not None:
            return
        if dist.value != ir.Local(dist.value.type, dist.binders[0].name) or len(dist.binders) > 1:
            return
        printer = builder.printer
        with printer.loops(init.binders):
            read = _read(self.model.variable(init.variable), init.binders)
            name = printer.scope.unique("value")
            builder.code.add(const("auto", name, printer.expr(read)))
            first = printer.first(dist.binders[0])
            printer.bind(dist.binders[0].name, name)
            holds = printer.expr(dist.condition)
            builder.code.add(when(op(op(name, "!=", first), "&&", not_(holds)), NOTHING))


def _read(variable: ir.Variable, binders: Sequence[ir.Binder]) -> ir.StateRead:
    return ir.StateRead(variable.type, variable.name, tuple(ir.Local(b.type, b.name) for b in binders))
