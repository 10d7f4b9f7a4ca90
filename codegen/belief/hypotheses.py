# SPDX-License-Identifier: Apache-2.0
"""Joint values of a factor's hidden variables in C++: written into states, read from them, weighed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.cpp.text import value_of
from hypgen.codegen.layout.naming import Scope
from hypgen.codegen.model.interface import Interface
from hypgen.codegen.model.model_functions import arguments, density, density_needs
from hypgen.codegen.passes.guards import own_value
from hypgen.codegen.tree.expr import Expr, Operand, call, method, number, of, op, plus
from hypgen.codegen.tree.statements import CONTINUE, Do, Function, Return, assign, var, when
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import shape
from hypgen.dsl.types import length_of, size_of

# The local that stands for the member at hand, whatever else goes by the name of the family's binder.
MEMBER = "%member"


class Hypotheses:
    """Names and prints what deals with joint values of one model's factors."""

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        self.context = interface.context
        self.model = interface.model
        self.exact = [f for f in self.model.factors if f.exact]
        self.sampled = [f for f in self.model.factors if not f.exact]
        self.updates = [u for stage in self.model.stages() for u in stage]
        unique = self.context.names.struct.unique
        self.put = {f.element: unique(f"put_{f.element}") for f in self.exact}
        self.code = {f.element: unique(f"code_of_{f.element}") for f in self.exact}
        self.start = {f.element: unique(f"start_{f.element}") for f in self.exact}
        self.advance = {f.element: unique(f"advance_{f.element}") for f in self.exact}
        fields = Scope({"Posterior"})
        self.field = {f.element: fields.unique(f.element) for f in self.exact}  # of Posterior
        self.copy = {f.element: unique(f"copy_{f.element}") for f in self.sampled}
        hidden = {name for f in self.exact for name in f.variables}
        self.first = {n: unique(f"density_init_{n}") for n in sorted(hidden)}
        drawn = [u.variable for f in self.exact if not self._certain(f) for u in self._updates(f)]
        self.moved = {n: unique(f"density_{n}") for n in drawn}

    # What a factor consists of -------------------------------------------------------------------

    def _updates(self, factor: ir.Factor) -> list[ir.Assign]:
        return [u for u in self.updates if u.variable in factor.variables]

    def _certain(self, factor: ir.Factor) -> bool:
        return all(isinstance(u.dist, ir.Certain) for u in self._updates(factor))

    def _fixed(self, factor: ir.Factor) -> list[ir.Variable]:
        return [v for v in map(self.model.variable, factor.variables) if v.fixed]

    @contextmanager
    def _own(self, builder: Builder, factor: ir.Factor, binders: Sequence[ir.Binder]) -> Iterator[None]:
        """Loop over a variable's own entries; the first binder stands for the member at hand."""
        printer, own = builder.printer, list(binders)
        if factor.binder is not None:
            printer.locals[own.pop(0).name] = printer.locals[MEMBER]
        with printer.loops(own):
            yield

    def _member(self, builder: Builder, factor: ir.Factor) -> list[Expr]:
        """Return the member's local as an argument; none where there is no family."""
        return [] if factor.binder is None else [builder.printer.locals[MEMBER]]

    def _position(self, builder: Builder, factor: ir.Factor) -> Expr:
        """Return where the member at hand stands, from 0."""
        if factor.binder is None:
            return number(0)
        type_ = factor.binder.type
        return builder.printer.code_expr(ir.Local(type_, MEMBER), type_)

    def _entries(self, factor: ir.Factor) -> Iterator[tuple[ir.Variable, list[ir.Binder]]]:
        for variable in map(self.model.variable, factor.variables):
            yield variable, [ir.Binder(f"i{n}", t) for n, t in enumerate(variable.indices)]

    def _read(
        self, builder: Builder, variable: ir.Variable, binders: Sequence[ir.Binder], primed: bool
    ) -> Expr:
        return builder.printer.expr(ir.StateRead(variable.type, variable.name, locals_of(binders), primed))

    @contextmanager
    def _members(self, builder: Builder, factor: ir.Factor) -> Iterator[None]:
        """Loop over the factor's members."""
        printer, binder = builder.printer, factor.binder
        with printer.loops([] if binder is None else [binder]):
            if binder is not None:
                printer.locals[MEMBER] = printer.locals[binder.name]
            yield

    def _given_member(self, builder: Builder, factor: ir.Factor) -> Builder:
        """Take the member at hand as an argument."""
        if factor.binder is not None:
            builder.local(factor.binder.name, factor.binder.type)
            builder.printer.locals[MEMBER] = builder.printer.locals[factor.binder.name]
        return builder

    def owners(self, factor: ir.Factor) -> list[str]:
        """Return which of ``fixed`` and ``state`` hold the factor's variables."""
        kinds = {self.model.variable(name).fixed for name in factor.variables}
        return [owner for owner, fixed in (("fixed", True), ("state", False)) if fixed in kinds]

    def _scratch(self, builder: Builder, factor: ir.Factor, state: str, *more: Operand) -> list[Operand]:
        """Return the arguments of what writes or reads joint values: of ``next`` where ``state`` says so."""
        owners = [state if owner == "state" else owner for owner in self.owners(factor)]
        return [*owners, *self._member(builder, factor), *more]

    def _given_owners(self, factor: ir.Factor, const: str) -> Builder:
        types = {"fixed": f"{const}Fixed&", "state": f"{const}State&"}
        builder = self.interface.given([(types[owner], owner) for owner in self.owners(factor)])
        return self._given_member(builder, factor)

    def _single(self, factor: ir.Factor) -> bool:
        """Return whether the joint value is that of one scalar."""
        digits = sum(_digits(self.model.variable(name), factor) for name in factor.variables)
        return digits == 1

    def _place(self, builder: Builder, factor: ir.Factor, array: Operand) -> Expr:
        """Return a pointer to the member's probabilities."""
        if factor.binder is None:
            return of(array)
        position, step = self._position(builder, factor), stored(factor)
        return plus(array, position if step == 1 else position * step)

    # Hypotheses ----------------------------------------------------------------------------------

    def _put(self, factor: ir.Factor) -> Function:
        """Return what writes a joint value into the states."""
        builder = self._given_owners(factor, "").take("std::int32_t", "value")
        code, single = builder.code, self._single(factor)
        if not single:
            place = builder.printer.scope.unique("place")
            code.add(var("std::int32_t", place, factor.size))
        for variable, binders in self._entries(factor):
            size = size_of(variable.type)
            with self._own(builder, factor, binders):
                digit = of("value")
                if not single:
                    code.add(assign(place, size, "/="))
                    digit = digit / place % size
                value = value_of(digit, variable.type)
                indices = builder.printer.exprs(locals_of(binders))
                setter = self.context.names.setters[variable.name]
                owner = "fixed" if variable.fixed else "state"
                code.add(Do(method(owner, setter, *indices, value)))
        comment = [f"// Writes a joint value of {factor.element}, one of {factor.size}."]
        return builder.done("void", self.put[factor.element], comment)

    def _code(self, factor: ir.Factor) -> Function:
        builder = self._given_owners(factor, "const ")
        if not self._single(factor):
            builder.code.add(var("std::int32_t", "value", 0))
        for variable, binders in self._entries(factor):
            with self._own(builder, factor, binders):
                read = ir.StateRead(variable.type, variable.name, locals_of(binders))
                digit = builder.printer.code_expr(read, variable.type)
                if self._single(factor):
                    builder.code.add(Return(digit))
                else:
                    total = plus(of("value") * size_of(variable.type), digit)
                    builder.code.add(assign("value", total))
        if not self._single(factor):
            builder.code.add(Return(of("value")))
        return builder.done("std::int32_t", self.code[factor.element])

    def _densities(self, factor: ir.Factor) -> list[Function]:
        found = []
        for assigns, names in ((self.model.inits, self.first), (tuple(self.updates), self.moved)):
            for a in assigns:
                if a.variable in factor.variables and a.variable in names:
                    type_ = self.model.variable(a.variable).type
                    found.append(density(a, type_, names[a.variable], self.context))
        return found

    def _weigh_draws(
        self, builder: Builder, factor: ir.Factor, assigns: Sequence[ir.Assign], primed: bool, weight: str
    ) -> None:
        """Append the product of the densities of the values that the states hold."""
        names = self.moved if primed else self.first
        for drawn in assigns:
            variable = self.model.variable(drawn.variable)
            with self._own(builder, factor, drawn.binders):
                value = self._read(builder, variable, drawn.binders, primed)
                more = builder.printer.exprs(locals_of(drawn.binders))
                given = arguments(density_needs(drawn.dist, self.context), self.context, *more, value)
                builder.code.add(assign(weight, call(names[drawn.variable], *given), "*="))

    def _put_outcome(self, builder: Builder, factor: ir.Factor, g: str, h: str) -> None:
        """Append what writes ``g`` into the next state; a variable that never changes is that of ``h``."""
        place = factor.size
        for variable in map(self.model.variable, factor.variables):
            radix = _radix(variable, factor)
            place //= radix
            if variable.fixed:
                digits = [of(name) / place % radix for name in (g, h)]
                builder.code.add(when(op(digits[0], "!=", digits[1]), CONTINUE))
        builder.code.add(Do(call(self.put[factor.element], *self._scratch(builder, factor, "next", g))))

    def _copy(self, factor: ir.Factor) -> Function:
        """Return what copies one member's hidden variables from one particle to another."""
        builder = self.interface.given(
            [
                ("const Fixed&", "fixed"),
                ("const State&", "state"),
                ("Fixed&", "to_fixed"),
                ("State&", "to_state"),
            ]
        )
        self._given_member(builder, factor)
        for variable, binders in self._entries(factor):
            with self._own(builder, factor, binders):
                indices = builder.printer.exprs(locals_of(binders))
                value = self._read(builder, variable, binders, False)
                setter = self.context.names.setters[variable.name]
                owner = "to_fixed" if variable.fixed else "to_state"
                builder.code.add(Do(method(owner, setter, *indices, value)))
        return builder.done("void", self.copy[factor.element])


def stored(factor: ir.Factor) -> int:
    """Return how many numbers a member's posterior takes: of two values, one probability is enough."""
    if factor.moments is not None:
        return 2
    return 1 if factor.size == 2 else factor.size


def locals_of(binders: Sequence[ir.Binder]) -> tuple[ir.Local, ...]:
    """Return the binders' current values."""
    return tuple(ir.Local(b.type, b.name) for b in binders)


def keeps(assign: ir.Assign) -> bool:
    """Return whether the update leaves the variable as it is."""
    return isinstance(assign.dist, ir.Certain) and shape(assign.dist.value) == shape(own_value(assign))


def _digits(variable: ir.Variable, factor: ir.Factor) -> int:
    return length_of(variable.indices) // factor.members


def _radix(variable: ir.Variable, factor: ir.Factor) -> int:
    return int(size_of(variable.type) ** _digits(variable, factor))
