# SPDX-License-Identifier: Apache-2.0
"""Values of fixed state that particles move one by one (``value_moves.hpp``)."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.layout.state_layout import WORD, Field, pack
from hypgen.codegen.model.interface import PLACE, Interface
from hypgen.codegen.model.model_functions import arguments, density, density_needs
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

    def density_functions(self) -> list[template_data.Function]:
        """Return the densities of the hidden variables' inits."""
        variable = self.model.variable
        return [
            density(a, variable(a.variable).type, self.densities[a.variable], self.context)
            for a in self.inits
        ]

    def all(self) -> list[template_data.Function]:
        """Return what the runtime calls."""
        return [self._size(), self._value(), self._put(), self._init_density(), self.interface.weigh_hidden()]

    def _size(self) -> template_data.Function:
        builder = self.interface.given([("int", "entry")])
        self._choose(builder, [f"return {size_of(f.type)};" for f in self.fields])
        comment = ["// How many values an entry of a hidden variable may have."]
        return builder.done("std::int32_t", "hidden_size", comment)

    def _value(self) -> template_data.Function:
        builder = self.interface.given([("const Fixed&", "fixed"), ("int", "entry")])
        gets = (f"bits::get({', '.join(place)})" for place in self._places())
        self._choose(builder, [f"return static_cast<std::int32_t>({get});" for get in gets])
        return builder.done("std::int32_t", "hidden_value", ["// Such a value, numbered from 0."])

    def _put(self) -> template_data.Function:
        builder = self.interface.given([("Fixed&", "fixed"), ("int", "entry"), ("std::int32_t", "value")])
        puts = []
        for word, shift, width in self._places():
            put = f"bits::put({word}, {shift}, {width}, static_cast<std::uint32_t>(value))"
            puts.append(f"{word} = {put};")
        self._choose(builder, puts, ends=False)
        return builder.done("void", "put_hidden")

    def _choose(self, builder: Builder, lines: Sequence[str], ends: bool = True) -> None:
        """Append one line for each field, under the condition that the entry is the field's."""
        end = 0
        for number, (field, line) in enumerate(zip(self.fields, lines, strict=True)):
            end += field.length
            last = number == len(lines) - 1
            test = "" if last else f"if (entry < {end}) "
            other = "else " if number and not ends else ""
            builder.code.add(f"{other}{test}{line}")

    def _places(self) -> list[tuple[str, str, str]]:
        """Return word, shift and width of the entry at hand, for each field."""
        found, start = [], 0
        for field in self.fields:
            found.append(_place(field, start))
            start += field.length
        return found

    def _init_density(self) -> template_data.Function:
        builder = self.interface.given(PLACE)
        for init in self.inits:
            self._refuse_outside(builder, init)
        builder.code.add("double weight = 1.0;")
        for init in self.inits:
            needs = density_needs(init.dist, self.context)
            with builder.printer.loops(init.binders):
                read = _read(self.model.variable(init.variable), init.binders)
                more = [*map(builder.printer.text, read.indices), builder.printer.text(read)]
                call = f"{self.densities[init.variable]}({arguments(needs, self.context, *more)})"
                builder.code.add(f"weight *= {call};")
                builder.code.add("if (!(weight > 0.0)) return 0.0;")
        builder.code.add("return weight;")
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
            builder.code.add(f"const auto {name} = {printer.text(read)};")
            first = printer.first(dist.binders[0])
            printer.locals[dist.binders[0].name] = name
            holds = printer.text(dist.condition)
            builder.code.add(f"if ({name} != {first} && !({holds})) return 0.0;")


def _read(variable: ir.Variable, binders: Sequence[ir.Binder]) -> ir.StateRead:
    return ir.StateRead(variable.type, variable.name, tuple(ir.Local(b.type, b.name) for b in binders))


def _place(field: Field, start: int) -> tuple[str, str, str]:
    entry = f"(entry - {start})" if start else "entry"
    base = f"{field.word}"
    if field.length == 1:
        return f"fixed.words[{base}]", f"{field.shift}", f"{field.width}"
    place = entry if field.stride == 1 else f"{entry} * {field.stride}"
    place = f"({field.shift} + {place})" if field.shift else place
    word = f"{place} / {WORD}" if not field.word else f"{base} + {place} / {WORD}"
    return f"fixed.words[{word}]", f"static_cast<std::uint32_t>({place} % {WORD})", f"{field.width}"
