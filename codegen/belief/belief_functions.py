# SPDX-License-Identifier: Apache-2.0
"""What ``belief(e)`` and ``deviation(e)`` stand for, and the beliefs that the history keeps for them."""

from __future__ import annotations

from hypgen.codegen.belief.factor_functions import FactorFunctions
from hypgen.codegen.belief.hypotheses import stored
from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.expressions import MULTIPLY, ExprPrinter
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.layout import history_layout
from hypgen.dsl import ir


class BeliefFunctions:
    """Builds the functions of one model's beliefs, and prints what keeps their posteriors."""

    def __init__(self, factors: FactorFunctions) -> None:
        self.factors = factors
        self.context = factors.context
        self.kept = [f for f in factors.model.factors if f.element in factors.model.history.beliefs]

    def all(self) -> list[template_data.Function]:
        """Return the functions of the beliefs that are more than a stored number."""
        return [self._answer(read) for read in self.context.beliefs.values()]

    def _answer(self, read: ir.BeliefRead) -> template_data.Function:
        factor = next(f for f in self.kept if f.element == read.element)
        needs = self.context.needs.belief(read.number)
        builder = Builder(self.context).given(needs, fixed="Fixed", state="State")
        for local in history_layout.locals_in(read):
            builder.local(local.name, local.type)
        code, printer, members = builder.code, builder.printer, []
        if read.index is not None:
            member = printer.scope.unique("member")
            code.add(f"const auto {member} = {printer.text(read.index)};")
            members = [member]
        if factor.moments is not None:
            self._over_points(builder, factor, read, members)
        else:
            self._over_values(builder, factor, read, members)
        return builder.done("float", self.context.names.beliefs[read.number])

    def _over_values(
        self, builder: Builder, factor: ir.Factor, read: ir.BeliefRead, members: list[str]
    ) -> None:
        """Append the mean or deviation over an exact posterior."""
        code, printer = builder.code, builder.printer
        total, h, p = (printer.scope.unique(name) for name in ("total", "h", "p"))
        code.add(f"moments::Sums {total};" if read.deviation else f"float {total} = 0.0f;")
        with printer.block(f"for (std::int32_t {h} = 0; {h} < {factor.size}; ++{h})"):
            code.add(f"const float {p} = {self._chance(factor, members, h)};")
            code.add(f"if (!({p} > 0.0f)) continue;")
            written = ", ".join([*self.factors.owners(factor), *members, h])
            code.add(f"{self.factors.put[factor.element]}({written});")
            if read.deviation:
                code.add(f"{total}.add(static_cast<double>({p}), {_double(printer, read.operand)});")
            else:
                code.add(f"{total} += {p} * {printer.text(read.operand, MULTIPLY + 1)};")
        code.add(f"return static_cast<float>({total}.deviation());" if read.deviation else f"return {total};")

    def _over_points(
        self, builder: Builder, factor: ir.Factor, read: ir.BeliefRead, members: list[str]
    ) -> None:
        """Append the mean or deviation under the law that is kept by two numbers."""
        code, printer = builder.code, builder.printer
        known, points, total = (printer.scope.unique(name) for name in ("known", "points", "total"))
        getter = self.context.names.history[history_layout.belief_key(factor.element)]
        numbers = (f"history.{getter}({', '.join([*members, place])})" for place in ("0", "1"))
        code.add(f"const float {known}[2] = {{{', '.join(numbers)}}};")
        if factor.binder is not None:
            printer.locals[factor.binder.name] = members[0]
        law = self.factors.law(builder, factor, "law", known)
        code.add(f"const moments::Points {points}({law});")
        code.add(f"moments::Sums {total};")
        with self.factors.points(builder, f"{points}.at({{0}})") as x:
            written = ", ".join([*self.factors.owners(factor), *members, x])
            code.add(f"{self.factors.put[factor.element]}({written});")
            code.add(f"{total}.add({law}.density({x}), {_double(printer, read.operand)});")
        code.add(f"return static_cast<float>({total}.{'deviation' if read.deviation else 'mean'}());")

    def _chance(self, factor: ir.Factor, members: list[str], h: str) -> str:
        getter = self.context.names.history[history_layout.belief_key(factor.element)]
        if factor.size != 2:
            return f"history.{getter}({', '.join([*members, h])})"
        true = f"history.{getter}({', '.join(members)})"
        return f"{h} != 0 ? {true} : 1.0f - {true}"

    # Posteriors in the history -------------------------------------------------------------------

    def start(self, builder: Builder) -> None:
        """Append the posteriors at the start to ``init_history``."""
        for factor in self.kept:
            name = self._array(builder, factor, "now")
            builder.code.add(f"{self.factors.start[factor.element]}(params, fixed, state, {name});")
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
            with builder.printer.block(f"for (int i = 0; i < {length}; ++i)"):
                code.add(f"{now}[i] = {before}[i];")
            code.join()
            given = f"params, fixed, state, {action}, key, next, {before}, {now}"
            code.add(f"{self.factors.advance[factor.element]}({given});")
            self._store(builder, factor, now, "after")

    def _advance_moments(self, builder: Builder, factor: ir.Factor, action: str) -> None:
        """Append the same for mean and deviation, which are advanced in their place."""
        now = self._array(builder, factor, "now")
        self._load(builder, factor, now)
        advance = self.factors.advance[factor.element]
        builder.code.add(f"{advance}(params, fixed, state, {action}, key, next, {now});")
        self._store(builder, factor, now, "after")

    def _load(self, builder: Builder, factor: ir.Factor, name: str) -> None:
        getter = self.context.names.history[history_layout.belief_key(factor.element)]
        with builder.printer.loops(self._entries(factor)):
            place, value = self._entry(builder, factor)
            builder.code.add(f"{name}[{place}] = history.{getter}({value});")

    def _array(self, builder: Builder, factor: ir.Factor, name: str) -> str:
        local = builder.printer.scope.unique(f"{factor.element}_{name}")
        builder.code.add(f"float {local}[{factor.members * stored(factor)}];")
        return local

    def _store(self, builder: Builder, factor: ir.Factor, name: str, owner: str) -> None:
        setter = self.context.names.history_setters[history_layout.belief_key(factor.element)]
        with builder.printer.loops(self._entries(factor)):
            place, index = self._entry(builder, factor)
            value = f"{name}[{place}]"
            builder.code.add(f"{owner}.{setter}({', '.join([index, value] if index else [value])});")

    def _entries(self, factor: ir.Factor) -> list[ir.Binder]:
        key = history_layout.belief_key(factor.element)
        field = next(f for f in history_layout.fields(self.factors.model) if f.key == key)
        return [ir.Binder(f"i{n}", t) for n, t in enumerate(field.indices)]

    def _entry(self, builder: Builder, factor: ir.Factor) -> tuple[str, str]:
        """Return the place of the entry at hand among the stored numbers, and its indexes as arguments."""
        binders = self._entries(factor)
        locals_ = [ir.Local(b.type, b.name) for b in binders]
        place = builder.printer.flat(locals_, [b.type for b in binders])
        return place, builder.printer.arguments(locals_)


def _double(printer: ExprPrinter, operand: ir.Expr) -> str:
    return f"static_cast<double>({printer.text(operand)})"
