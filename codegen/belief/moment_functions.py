# SPDX-License-Identifier: Apache-2.0
"""The functions of beliefs about floats that a policy knows by mean and deviation.

docs/internals/beliefs.md fixes the operations; the interpreter repeats them bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hypgen.codegen.belief.evidence import Watch, Weighing
from hypgen.codegen.belief.hypotheses import keeps
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.cpp.law_moments import add_law
from hypgen.codegen.model.interface import PLACE, Digit, Interface
from hypgen.codegen.tree.expr import TRUE, Literal, call, method, of
from hypgen.codegen.tree.statements import Declare, Do, Function, While, const, for_below, var
from hypgen.dsl import ir

_SCRATCH = [("const Params&", "params"), ("Fixed", "fixed"), ("State", "state")]


class MomentFunctions(Weighing):
    """Builds what starts and advances mean and deviation. Names are of elements: ``advance_target``."""

    def __init__(self, interface: Interface) -> None:
        super().__init__(interface)
        unique, kept = self.context.names.struct.unique, self.model.history.beliefs
        self.matched = [f for f in self.model.factors if f.moments is not None and f.element in kept]
        for factor in self.matched:
            for names, name in ((self.put, "put"), (self.start, "start"), (self.advance, "advance")):
                names[factor.element] = unique(f"{name}_{factor.element}")

    def moment_functions(self) -> list[Function]:
        """Return the functions in the order in which they call each other."""
        return [
            each(factor)
            for factor in self.matched
            for each in (self._put_point, self._start_moments, self._advance_moments)
        ]

    def law(self, builder: Builder, factor: ir.Factor, name: str, known: str) -> str:
        """Append the law that the mean and deviation at ``known`` stand for; return its local."""
        assert factor.moments is not None
        local, printer = builder.printer.scope.unique(name), builder.printer
        given = (of(known), *printer.exprs(factor.moments.ends or ()))
        builder.code.add(Declare("const moments::Law", local, arguments=given))
        return local

    def _variable(self, factor: ir.Factor) -> ir.Variable:
        assert factor.moments is not None
        return self.model.variable(factor.moments.variable)

    def _put_point(self, factor: ir.Factor) -> Function:
        """Return what writes a value of the float into a state."""
        builder = self._given_owners(factor, "").take("float", "value")
        owner = "fixed" if self._variable(factor).fixed else "state"
        setter = self.context.names.setters[self._variable(factor).name]
        builder.code.add(Do(method(owner, setter, *self._member(builder, factor), "value")))
        return builder.done("void", self.put[factor.element])

    def _start_moments(self, factor: ir.Factor) -> Function:
        """Return what gives mean and deviation before the first step."""
        builder = self.interface.given([*(_SCRATCH if factor.first else PLACE), ("float*", "after")])
        watches = self._watches(builder, factor, factor.first)
        init = next(i for i in self.model.inits if i.variable == self._variable(factor).name)
        with self._members(builder, factor):
            place = self._known(builder, factor, "after")
            mixture = builder.printer.scope.unique("mixture")
            builder.code.add(Declare("moments::Mixture", mixture))
            with self._own(builder, factor, init.binders):
                add_law(init.dist, mixture, builder.printer)
            builder.code.add(Do(method(mixture, "store", place)))
            if watches:
                self._learn(builder, factor, self._first_seen(builder, factor), watches, place, ("state",))
        return builder.done("void", self.start[factor.element])

    def _advance_moments(self, factor: ir.Factor) -> Function:
        """Return what takes mean and deviation over a step."""
        assert factor.moments is not None
        fixed = "Fixed" if self._fixed(factor) else "const Fixed&"
        builder = self.interface.acting(
            [
                *[("const Params&", "params"), (fixed, "fixed"), ("State", "state"), ("int", "action")],
                *[(self.interface.key.argument, "key"), ("State", "next"), ("float*", "after")],
            ]
        )
        digits = self._seen(builder, [factor])
        watches = self._watches(builder, factor)
        moves = TRUE if factor.binder is None else self._moves(builder, factor)
        with self._members(builder, factor):
            self._skip(builder, factor, watches, moves)
            place = self._known(builder, factor, "after")
            if not factor.moments.still:
                self._predict(builder, factor, place)
            if watches:
                states = ("state", "next") if factor.moments.still else ("next",)
                self._learn(builder, factor, digits, watches, place, states)
        return builder.done("void", self.advance[factor.element])

    def _known(self, builder: Builder, factor: ir.Factor, array: str) -> str:
        """Append a pointer to the member's mean and deviation, and return it."""
        place = self._place(builder, factor, array)
        if place == of(array):
            return array
        local = builder.printer.scope.unique("known")
        builder.code.add(var("float* const", local, place))
        return local

    @contextmanager
    def points(self, builder: Builder, owner: str, point: str) -> Iterator[str]:
        """Loop over the points of ``owner``, whose member function ``point`` gives them; yield a point."""
        k, x = (builder.printer.scope.unique(name) for name in ("k", "x"))
        with builder.printer.block(for_below(k, Literal("moments::kPoints"), "int")):
            builder.code.add(const("float", x, method(owner, point, k)))
            yield x

    def put_point(self, builder: Builder, factor: ir.Factor, states: Sequence[str], x: str) -> None:
        """Append what writes a point into states, or into the fixed part."""
        for state in states if "state" in self.owners(factor) else ("state",):
            builder.code.add(Do(call(self.put[factor.element], *self._scratch(builder, factor, state, x))))

    def _predict(self, builder: Builder, factor: ir.Factor, place: str) -> None:
        """Append what the update makes of mean and deviation."""
        code, unique = builder.code, builder.printer.scope.unique
        update = next(u for u in self._updates(factor) if not keeps(u))
        law = self.law(builder, factor, "before", place)
        points, mixture = unique("points"), unique("mixture")
        code.add(Declare("const moments::Points", points, arguments=(of(law),)))
        code.add(Declare("moments::Mixture", mixture))
        with self.points(builder, points, "at") as x:
            self.put_point(builder, factor, ("state",), x)
            code.add(Do(method(mixture, "at", x, method(law, "density", x))))
            with self._own(builder, factor, update.binders):
                add_law(update.dist, mixture, builder.printer)
        code.add(Do(method(mixture, "move", place)))

    def _learn(
        self,
        builder: Builder,
        factor: ir.Factor,
        digits: dict[str, Digit],
        watches: list[Watch],
        place: str,
        states: Sequence[str],
    ) -> None:
        """Append what the evidence makes of mean and deviation."""
        code, unique = builder.code, builder.printer.scope.unique
        law, update = self.law(builder, factor, "prior", place), unique("update")
        code.add(Declare("moments::Update", update, arguments=(of(law),)))
        with builder.printer.block(While(method(update, "due"))):
            with self.points(builder, update, "point") as x:
                self.put_point(builder, factor, states, x)
                likelihood = unique("likelihood")
                code.add(var("double", likelihood, Literal("1.0")))
                self._weigh(builder, factor, digits, watches, likelihood)
                code.add(Do(method(update, "take", x, likelihood)))
            code.add(Do(method(update, "sweep")))
        code.add(Do(method(update, "store", place)))
