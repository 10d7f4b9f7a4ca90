# SPDX-License-Identifier: Apache-2.0
"""What ``belief(e)`` and ``deviation(e)`` stand for, and the beliefs that the history keeps for them."""

from __future__ import annotations

from hypgen.codegen.belief.factor_functions import FactorFunctions
from hypgen.codegen.belief.hypotheses import stored
from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.layout import history_layout
from hypgen.codegen.tree.expr import Choice, Expr, Literal, braces, call, cast, method, not_, of, op
from hypgen.codegen.tree.statements import (
    CONTINUE,
    Declare,
    Do,
    Function,
    Return,
    assign,
    const,
    for_below,
    var,
    when,
)
from hypgen.dsl import ir


class BeliefFunctions:
    """Builds the functions of one model's beliefs, and prints what keeps their posteriors."""

    def __init__(self, factors: FactorFunctions) -> None:
        self.factors = factors
        self.context = factors.context
        self.kept = [f for f in factors.model.factors if f.element in factors.model.history.beliefs]

    def all(self) -> list[Function]:
        """Return the functions of the beliefs that are more than a stored number."""
        return [self._answer(read) for read in self.context.beliefs.values()]

    def _answer(self, read: ir.BeliefRead) -> Function:
        factor = next(f for f in self.kept if f.element == read.element)
        needs = self.context.needs.belief(read.number)
        builder = Builder(self.context).given(needs, fixed="Fixed", state="State")
        for local in history_layout.locals_in(read):
            builder.local(local.name, local.type)
        code, printer, members = builder.code, builder.printer, list[Expr]()
        if read.index is not None:
            own = printer.scope.unique("member")
            code.add(const("auto", own, printer.expr(read.index)))
            members = [of(own)]
        if factor.moments is not None:
            self._over_points(builder, factor, read, members)
        else:
            self._over_values(builder, factor, read, members)
        return builder.done("float", self.context.names.beliefs[read.number])

    def _over_values(
        self, builder: Builder, factor: ir.Factor, read: ir.BeliefRead, members: list[Expr]
    ) -> None:
        """Append the mean or deviation over an exact posterior."""
        code, printer = builder.code, builder.printer
        total, h, p = (printer.scope.unique(name) for name in ("total", "h", "p"))
        zero = Literal("0.0f")
        code.add(Declare("moments::Sums", total) if read.deviation else var("float", total, zero))
        with printer.block(for_below(h, factor.size)):
            code.add(const("float", p, self._chance(factor, members, h)))
            code.add(when(not_(op(p, ">", zero)), CONTINUE))
            owners = self.factors.owners(factor)
            code.add(Do(call(self.factors.put[factor.element], *owners, *members, h)))
            if read.deviation:
                code.add(Do(method(total, "add", cast("double", p), _double(printer, read.operand))))
            else:
                code.add(assign(total, of(p) * printer.expr(read.operand), "+="))
        code.add(Return(cast("float", method(total, "deviation")) if read.deviation else of(total)))

    def _over_points(
        self, builder: Builder, factor: ir.Factor, read: ir.BeliefRead, members: list[Expr]
    ) -> None:
        """Append the mean or deviation under the law that is kept by two numbers."""
        code, printer = builder.code, builder.printer
        known, points, total = (printer.scope.unique(name) for name in ("known", "points", "total"))
        getter = self.context.names.history[history_layout.belief_key(factor.element)]
        numbers = (method("history", getter, *members, place) for place in (0, 1))
        code.add(Declare("const float", known, braces("", *numbers), (2,)))
        if factor.binder is not None:
            printer.locals[factor.binder.name] = members[0]
        law = self.factors.law(builder, factor, "law", known)
        code.add(Declare("const moments::Points", points, arguments=(of(law),)))
        code.add(Declare("moments::Sums", total))
        with self.factors.points(builder, points, "at") as x:
            owners = self.factors.owners(factor)
            code.add(Do(call(self.factors.put[factor.element], *owners, *members, x)))
            density = method(law, "density", x)
            code.add(Do(method(total, "add", density, _double(printer, read.operand))))
        code.add(Return(cast("float", method(total, "deviation" if read.deviation else "mean"))))

    def _chance(self, factor: ir.Factor, members: list[Expr], h: str) -> Expr:
        getter = self.context.names.history[history_layout.belief_key(factor.element)]
        if factor.size != 2:
            return method("history", getter, *members, h)
        true = method("history", getter, *members)
        return Choice(op(h, "!=", 0), true, Literal("1.0f") - true)

    # Posteriors in the history -------------------------------------------------------------------

    def start(self, builder: Builder) -> None:
        """Append the posteriors at the start to ``init_history``."""
        for factor in self.kept:
            name = self._array(builder, factor, "now")
            start = self.factors.start[factor.element]
            builder.code.add(Do(call(start, "params", "fixed", "state", name)))
            self._store(builder, factor, name, "history")

    def advance(self, builder: Builder, action: str) -> None:
        """Append the posteriors after a step to ``advance_history`` and ``roll_history``."""
        for factor in self.kept:
            if factor.moments is not None:
                self._advance_moments(builder, factor, action)
                continue
            before = self._array(builder, factor, "before")
            self._load(builder, factor, before)
            now = self._array(builder, factor, "now")
            code, length = builder.code, factor.members * stored(factor)
            with builder.printer.block(for_below("i", length, "int")):
                code.add(assign(of(now)["i"], of(before)["i"]))
            code.join()
            given = ("params", "fixed", "state", action, "key", "next", before, now)
            code.add(Do(call(self.factors.advance[factor.element], *given)))
            self._store(builder, factor, now, "after")

    def _advance_moments(self, builder: Builder, factor: ir.Factor, action: str) -> None:
        """Append the same for mean and deviation, which are advanced in their place."""
        now = self._array(builder, factor, "now")
        self._load(builder, factor, now)
        advance = self.factors.advance[factor.element]
        given = ("params", "fixed", "state", action, "key", "next", now)
        builder.code.add(Do(call(advance, *given)))
        self._store(builder, factor, now, "after")

    def _load(self, builder: Builder, factor: ir.Factor, name: str) -> None:
        getter = self.context.names.history[history_layout.belief_key(factor.element)]
        with builder.printer.loops(self._entries(factor)):
            place, index = self._entry(builder, factor)
            builder.code.add(assign(of(name)[place], method("history", getter, *index)))

    def _array(self, builder: Builder, factor: ir.Factor, name: str) -> str:
        local = builder.printer.scope.unique(f"{factor.element}_{name}")
        builder.code.add(Declare("float", local, dimensions=(factor.members * stored(factor),)))
        return local

    def _store(self, builder: Builder, factor: ir.Factor, name: str, owner: str) -> None:
        setter = self.context.names.history_setters[history_layout.belief_key(factor.element)]
        with builder.printer.loops(self._entries(factor)):
            place, index = self._entry(builder, factor)
            builder.code.add(Do(method(owner, setter, *index, of(name)[place])))

    def _entries(self, factor: ir.Factor) -> list[ir.Binder]:
        key = history_layout.belief_key(factor.element)
        field = next(f for f in history_layout.fields(self.factors.model) if f.key == key)
        return [ir.Binder(f"i{n}", t) for n, t in enumerate(field.indices)]

    def _entry(self, builder: Builder, factor: ir.Factor) -> tuple[Expr, list[Expr]]:
        """Return the place of the entry at hand among the stored numbers, and its indexes as arguments."""
        binders = self._entries(factor)
        locals_ = [ir.Local(b.type, b.name) for b in binders]
        place = builder.printer.flat(locals_, [b.type for b in binders])
        return place, builder.printer.exprs(locals_)


def _double(printer: ExprPrinter, operand: ir.Expr) -> Expr:
    return cast("double", printer.expr(operand))
