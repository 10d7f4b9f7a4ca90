# SPDX-License-Identifier: Apache-2.0
"""The functions of the factored filter: exact posteriors, and which unit is what.

docs/internals/beliefs.md fixes the operations; the interpreter repeats them bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.codegen.belief.evidence import Watch
from hypgen.codegen.belief.hypotheses import keeps, locals_of, stored
from hypgen.codegen.belief.unit_functions import UnitFunctions
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.model.interface import PLACE, Digit
from hypgen.codegen.model.model_functions import assigned
from hypgen.codegen.tree.expr import (
    FALSE,
    TRUE,
    Choice,
    Expr,
    Literal,
    all_of,
    braces,
    call,
    cast,
    member,
    method,
    not_,
    number,
    of,
    op,
    plus,
    shifted,
)
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
from hypgen.dsl.types import length_of

_ONE, _ZERO = Literal("1.0"), Literal("0.0")
_SCRATCH = [("const Params&", "params"), ("Fixed", "fixed"), ("State", "state")]


class FactorFunctions(UnitFunctions):
    """Builds the functions of one model's factors. Names are of elements: ``advance_rock``."""

    # Parts of the model's struct -----------------------------------------------------------------

    def fields(self) -> tuple[str, ...]:
        """Return the members of ``Posterior``."""
        return tuple(f"double {self.field[f.element]}[{f.members * stored(f)}];" for f in self.exact)

    def constants(self) -> list[str]:
        """Return what the runtime asks of the model about its factors."""
        return [
            f"static constexpr bool kFactored = {'true' if self.model.factored else 'false'};",
            f"static constexpr int kExactUnits = {sum(f.members for f in self.exact)};",
            f"static constexpr int kParticleUnits = {sum(f.members for f in self.sampled)};",
            *(super().constants() if self.model.factored else []),
        ]

    def all(self) -> list[Function]:
        """Return the functions in the order in which they call each other."""
        found: list[Function] = []
        for factor in self.exact:
            found += self._densities(factor)
            found += [self._put(factor), self._code(factor), self._start(factor), self._advance(factor)]
        found += self.moment_functions()
        found += [self._init_posterior(), self._advance_posterior()]
        if self.model.factored:
            found += [self._advance_visible(), self._unit_of()]
            if self.exact:
                found += [self._unit_size(), self._probability(), self._put_unit()]
            if self.sampled:
                found += self.units()
        return found

    # Exact posteriors ----------------------------------------------------------------------------

    def _start(self, factor: ir.Factor) -> Function:
        """Return what gives a factor's posterior before the first step, in floats or doubles."""
        builder = self.interface.given([*_SCRATCH, ("Real*", "after")])
        code, unique, n = builder.code, builder.printer.scope.unique, factor.size
        inits = [i for i in self.model.inits if i.variable in factor.variables]
        watches = self._watches(builder, factor, factor.first)
        possible = unique("possible")
        if watches:
            code.add(var("bool", possible, TRUE))
        with self._members(builder, factor):
            unseen = unique("unseen")
            sums, h, weight = unique("sums"), unique("h"), unique("likelihood")
            kind = self._sum_type(factor.first)
            code.add(Declare(kind, sums, dimensions=(n,)))
            if watches:
                code.add(Declare(kind, unseen, dimensions=(n,)))
            with builder.printer.block(for_below(h, n)):
                self._write(builder, factor, "state", h)
                code.add(var("double", weight, _ONE))
                self._weigh_draws(builder, factor, inits, False, weight)
                if watches:
                    code.add(assign(of(unseen)[h], _as(kind, weight)))
                    self._weigh(builder, factor, self._first_seen(builder, factor), watches, weight)
                code.add(assign(of(sums)[h], _as(kind, weight)))
            place = self._place(builder, factor, "after")
            seen = call(_normalise(n), sums, place)
            if watches:
                unlike = Do(call(_normalise(n), unseen, place))
                code.add(when(not_(seen), unlike, assign(possible, FALSE)))
            else:
                code.add(Do(seen))
        if watches:
            code.add(Return(of(possible)))
        comment = [f"// How likely each joint value h of {factor.element} is at the start."]
        return builder.done("bool" if watches else "void", self.start[factor.element], comment)

    def _advance(self, factor: ir.Factor) -> Function:
        """Return what takes a factor's posterior over a step; false where what was seen is impossible."""
        fixed = "Fixed" if self._fixed(factor) else "const Fixed&"
        builder = self.interface.acting(
            [
                *[("const Params&", "params"), (fixed, "fixed"), ("State", "state"), ("int", "action")],
                *[(self.interface.key.argument, "key"), ("State", "next")],
                *[("const Real*", "now"), ("Real*", "after")],
            ]
        )
        code, unique, n = builder.code, builder.printer.scope.unique, factor.size
        digits = self._seen(builder, [factor])
        watches = self._watches(builder, factor)
        moves = self._moves(builder, factor)
        possible = unique("possible")
        code.add(var("bool", possible, TRUE))
        with self._members(builder, factor):
            self._skip(builder, factor, watches, moves)
            sums, same, h, p = unique("sums"), unique("same"), unique("h"), unique("p")
            code.add(Declare(self._sum_type(factor.evidence), sums, braces(""), (n,)))
            code.add(var("bool", same, TRUE))
            with builder.printer.block(for_below(h, n)):
                place = self._place(builder, factor, "now")
                code.add(const("Real", p, call(f"posteriors::probability<{n}>", place, h)))
                code.add(when(not_(op(p, ">", braces("Real"))), CONTINUE))
                self._write(builder, factor, "state", h)
                if self._certain(factor):
                    if "state" in self.owners(factor):  # an update writes nothing where it keeps a value
                        self._write(builder, factor, "next", h)
                    self._certain_step(builder, factor, digits, watches, (sums, same, h, p))
                else:
                    self._drawn_step(builder, factor, digits, watches, (sums, same, h, p))
            place = self._place(builder, factor, "after")
            failed = op(not_(same), "&&", not_(call(_normalise(n), sums, place)))
            code.add(when(failed, assign(possible, FALSE)))
        code.add(Return(of(possible)))
        drawn = "" if self._certain(factor) else ", and g after it"
        comment = [
            f"// Bayes' rule for {factor.element}: its joint value is h before the step{drawn}.",
            "// Returns false where what was seen is impossible.",
        ]
        return builder.done("bool", self.advance[factor.element], comment)

    def _write(self, builder: Builder, factor: ir.Factor, state: str, h: str) -> None:
        """Append what writes a joint value into a state."""
        builder.code.add(Do(call(self.put[factor.element], *self._scratch(builder, factor, state, h))))

    def _certain_step(
        self,
        builder: Builder,
        factor: ir.Factor,
        digits: dict[str, Digit],
        watches: list[Watch],
        names: tuple[str, str, str, str],
    ) -> None:
        """Append the one outcome of a hypothesis whose updates draw nothing."""
        code, (sums, same, h, p) = builder.code, names
        for update in self._updates(factor):
            with self._own(builder, factor, update.binders):
                assigned(update, "next", builder)
        g = h
        if not all(keeps(u) for u in self._updates(factor)):
            g = builder.printer.scope.unique("g")
            given = self._scratch(builder, factor, "next")
            code.add(const("std::int32_t", g, call(self.code[factor.element], *given)))
        weight = builder.printer.scope.unique("likelihood")
        code.add(var("double", weight, _ONE))
        self._weigh(builder, factor, digits, watches, weight)
        tests = [of(same), *([op(g, "==", h)] if g != h else []), op(weight, "==", _ONE)]
        code.add(assign(same, all_of(tests)))
        code.add(assign(of(sums)[g], self._share(factor, p, weight), "+="))

    def _drawn_step(
        self,
        builder: Builder,
        factor: ir.Factor,
        digits: dict[str, Digit],
        watches: list[Watch],
        names: tuple[str, str, str, str],
    ) -> None:
        """Append all outcomes of a hypothesis."""
        code, (sums, same, h, p) = builder.code, names
        g, weight = builder.printer.scope.unique("g"), builder.printer.scope.unique("likelihood")
        with builder.printer.block(for_below(g, factor.size)):
            self._put_outcome(builder, factor, g, h)
            code.add(var("double", weight, _ONE))
            self._weigh_draws(builder, factor, self._updates(factor), True, weight)
            moved = assign(same, op(same, "&&", op(g, "!=", h)))
            code.add(when(op(weight, "==", _ZERO), moved, CONTINUE))
            self._weigh(builder, factor, digits, watches, weight)
            stays = Choice(op(g, "==", h), _ONE, _ZERO)
            code.add(assign(same, op(same, "&&", op(weight, "==", stays))))
            code.add(assign(of(sums)[g], self._share(factor, p, weight), "+="))

    def _sum_type(self, evidence: Sequence[ir.Evidence]) -> str:
        """Return the type of the sums that become a posterior: densities may leave the range of a float."""
        return "double" if self.model.weighs_floats(evidence) else "Real"

    def _share(self, factor: ir.Factor, p: str, weight: str) -> Expr:
        """Return what a hypothesis of probability ``p`` adds to a sum."""
        kind = self._sum_type(factor.evidence)
        return (of(p) if kind == "Real" else cast("double", p)) * _as(kind, weight)

    # What the runtime calls ----------------------------------------------------------------------

    def _init_posterior(self) -> Function:
        builder = self.interface.given([*PLACE, ("Posterior&", "after")])
        builder.code.add(assign("after", braces("Posterior")))
        told = bool(self.model.first_seen)
        if told:
            builder.code.add(var("bool", "possible", TRUE))
        for factor in self.exact:
            after = member("after", self.field[factor.element])
            start = call(self.start[factor.element], "params", "fixed", "state", after)
            builder.code.add(assign("possible", start, "&=") if factor.first else Do(start))
        if told:
            builder.code.add(Return(of("possible")))
        return builder.done("bool" if told else "void", "init_posterior")

    def _advance_posterior(self) -> Function:
        builder = self.interface.given(
            [
                *[*PLACE, ("int", "action"), (self.interface.key.argument, "key"), ("const State&", "next")],
                *[("const Posterior&", "now"), ("Posterior&", "after")],
            ]
        )
        builder.code.add(assign("after", "now"))
        builder.code.add(var("bool", "possible", TRUE))
        for factor in self.exact:
            numbers = (member(owner, self.field[factor.element]) for owner in ("now", "after"))
            given = ("params", "fixed", "state", "action", "key", "next")
            advanced = call(self.advance[factor.element], *given, *numbers)
            builder.code.add(assign("possible", advanced, "&="))
        builder.code.add(Return(of("possible")))
        return builder.done("bool", "advance_posterior")

    def _advance_visible(self) -> Function:
        """Return what moves the visible variables: to the values seen, or those that follow."""
        key = (self.interface.key.argument, "key")
        builder = self.interface.acting([*PLACE, ("int", "action"), key, ("State&", "next")])
        seen = {f.name for f in self.model.key if not f.observed}
        digits = self.interface.digits(builder, seen) if seen else {}
        builder.code.add(assign("next", "state"))
        for update in self.updates:
            if self.model.variable(update.variable).determined:
                with builder.printer.loops(update.binders):
                    assigned(update, "next", builder)
            elif update.variable in seen:
                with builder.printer.loops(update.binders):
                    indices = builder.printer.exprs(locals_of(update.binders))
                    setter = self.context.names.setters[update.variable]
                    value = digits[update.variable](update.binders)
                    builder.code.add(Do(method("next", setter, *indices, value)))
        return builder.done("void", "advance_visible")

    def _unit_size(self) -> Function:
        builder = self.interface.given([("int", "unit")])
        for factor in self._units(builder, self.exact):
            builder.code.add(Return(number(factor.size)))
        return builder.done("int", "unit_size")

    def _unit_of(self) -> Function:
        """Return what gives the unit of a flattened variable: exact ones, then the others; -1 if visible."""
        builder = self.interface.given([("int", "variable")])
        units: list[tuple[int, Expr]] = []  # of the variables below an end
        firsts: dict[str, tuple[int, ir.Factor]] = {}
        first, end = 0, 0
        for factor in (*self.exact, *self.sampled):
            firsts |= dict.fromkeys(factor.variables, (first, factor))
            first += factor.members
        for variable in self.model.variables:
            start, end = end, end + length_of(variable.indices)
            if variable.visible:
                unit = number(-1)
            else:
                base, factor = firsts[variable.name]
                each = length_of(variable.indices) // factor.members
                offset = shifted("variable", -start)
                offset = offset / each if each > 1 else offset
                unit = number(base) if factor.members == 1 else plus(base, offset) if base else offset
            if units and units[-1][1] == unit:
                units.pop()
            units.append((end, unit))
        if units[-1][1] == number(-1):
            units.pop()
        for end, unit in units:
            builder.code.add(when(op("variable", "<", end), Return(unit)))
        builder.code.add(Return(number(-1)))
        return builder.done("int", "unit_of")

    def _probability(self) -> Function:
        builder = self.interface.given(
            [("const Posterior&", "posterior"), ("int", "unit"), ("std::int32_t", "value")]
        )
        for factor in self._units(builder, self.exact):
            place = self._place(builder, factor, member("posterior", self.field[factor.element]))
            builder.code.add(Return(call(f"posteriors::probability<{factor.size}>", place, "value")))
        return builder.done("double", "probability")

    def _put_unit(self) -> Function:
        builder = self.interface.given(
            [("int", "unit"), ("std::int32_t", "value"), ("Fixed&", "fixed"), ("State&", "state")]
        )
        for factor in self._units(builder, self.exact):
            given = self._scratch(builder, factor, "state", "value")
            builder.code.add(Return(call(self.put[factor.element], *given)))
        return builder.done("void", "put_unit")


def _normalise(size: int) -> str:
    return f"posteriors::normalise<{size}>"


def _as(kind: str, weight: str) -> Expr:
    """Return a double as the type of a sum."""
    return of(weight) if kind == "double" else cast(kind, weight)
