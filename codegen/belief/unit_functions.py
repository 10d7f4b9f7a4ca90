# SPDX-License-Identifier: Apache-2.0
"""The functions of factors that particles keep: a unit's start, its step and how likely what was seen is.

A particle filter runs them again for past steps. So what depends on the step alone, and on no particle, is
computed once a step and kept: ``Evidence``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace

from hypgen.codegen.belief.evidence import Watch, told_by
from hypgen.codegen.belief.hypotheses import MEMBER, locals_of
from hypgen.codegen.belief.moment_functions import MomentFunctions
from hypgen.codegen.cpp.function_builder import Builder, origin
from hypgen.codegen.cpp.text import value_of
from hypgen.codegen.layout.naming import Scope
from hypgen.codegen.model.interface import PLACE, Interface, digit
from hypgen.codegen.model.model_functions import assigned
from hypgen.codegen.tree.expr import Literal, Member, call, cast, following, member, method, of, op, shifted
from hypgen.codegen.tree.statements import Comment, Declare, Do, Function, Return, assign, var
from hypgen.dsl import ir
from hypgen.dsl.types import length_of

_DRAW = [("const Params&", "params"), ("D&", "draws"), ("Fixed&", "fixed"), ("State&", "state")]
_MOVE = [*PLACE, ("int", "action"), ("const Evidence&", "seen"), ("D&", "draws"), ("State&", "next")]
_COPY = [*PLACE[1:], ("Fixed&", "to_fixed"), ("State&", "to_state")]
_EXPORT = [*PLACE[1:], ("double*", "out")]


class UnitFunctions(MomentFunctions):
    """Builds what a particle filter calls for each unit. Names are of elements: ``move_rock``."""

    def __init__(self, interface: Interface) -> None:
        super().__init__(interface)
        unique, scope = self.context.names.struct.unique, Scope({"next"})
        self.draw = {f.element: unique(f"draw_{f.element}") for f in self.sampled}
        self.move = {f.element: unique(f"move_{f.element}") for f in self.sampled}
        self.weigh = {f.element: unique(f"weigh_{f.element}") for f in self.sampled if self.model.first_seen}
        self.export = {f.element: unique(f"export_{f.element}") for f in self.sampled}
        used = {e.name for f in self.sampled for e in f.evidence if e.kind != "end"}
        fields = [f.name for f in self.interface.key.reading() if f.name in used]
        self.members = {name: scope.unique(f"observed_{name}") for name in fields}  # of Evidence
        self.watches = {f.element: self._kept(f, scope) for f in self.sampled}

    def evidence(self) -> tuple[str, ...]:
        """Return the members of ``Evidence``: what is visible next, digits of the key, whom they touch."""
        kept = [
            (self.members[f.name], f.indices) for f in self.interface.key.reading() if f.name in self.members
        ]
        for watch in (w for watches in self.watches.values() for w in watches):
            if isinstance(watch.touched, Member):
                kept.append((watch.touched.member, tuple(b.type for b in watch.evidence.binders)))
        arrays = [f"{name}[{length_of(types)}]" if types else name for name, types in kept]
        return ("State next;", *(f"std::int32_t {array};" for array in arrays))

    def units(self) -> list[Function]:
        """Return the functions in the order in which they call each other."""
        called = [
            (self._draw, self.draw, "void", "draw_unit", _DRAW),
            (self._move, self.move, "double", "move_unit", _MOVE),
            (self._copy, self.copy, "void", "copy_unit", _COPY),
            (self._export, self.export, "int", "export_unit", _EXPORT),
        ]
        found = [self._see()]
        if self.model.first_seen:
            called.append((self._weigh_start, self.weigh, "double", "weigh_start", PLACE))
        for each, names, result, name, arguments in called:
            found += [*map(each, self.sampled), self._of_unit(names, result, name, arguments)]
        return found

    def _of_unit(
        self, names: dict[str, str], result: str, name: str, arguments: list[tuple[str, str]]
    ) -> Function:
        """Return what calls the function of the unit's factor, for the member that the unit is."""
        builder = self.interface.given([("int", "unit"), *arguments])
        for factor in self._units(builder, self.sampled):
            given = (a for _, a in arguments)
            own = self._member(builder, factor)
            builder.code.add(Return(call(names[factor.element], *given, *own)))
        return builder.done(result, name)

    def _see(self) -> Function:
        """Return what computes the evidence of a step."""
        key = (self.interface.key.argument, "key")
        builder = self.interface.acting([*PLACE, ("int", "action"), key, ("Evidence&", "seen")])
        code = builder.code
        after = member("seen", "next")
        given = ("params", "fixed", "state", self.interface.code, "key", after)
        code.add(Do(call("advance_visible", *given)))
        if self.members:
            self.interface.keep_digits(
                builder, {name: member("seen", field) for name, field in self.members.items()}
            )
        watches = [w for watches in self.watches.values() for w in watches]
        touches = [(w.evidence, w.touched) for w in watches if w.touched is not None]
        if touches:
            code.add(Declare("const State&", "next", after, unused=True))
        for evidence, touched in touches:
            self._set_touch(builder, evidence, touched)
        return builder.done("void", "see", ["// What all particles of a step share."])

    def _kept(self, factor: ir.Factor, scope: Scope) -> list[Watch]:
        """Return how the factor's evidence is watched, with what it touches in ``Evidence``."""
        found = []
        for evidence in factor.evidence:
            name = told_by(evidence)
            watch = self._kept_watch(evidence, factor, of(name))
            if watch.touched is not None:
                watch = replace(watch, touched=member("seen", scope.unique(name)))
            found.append(watch)
        return found

    def _draw(self, factor: ir.Factor) -> Function:
        """Return what draws one member's initial values."""
        builder = self._given_member(self.interface.given(_DRAW), factor)
        for group in self.model.init_groups(False):
            for init in (a for a in group if a.variable in factor.variables):
                owner = "fixed" if self.model.variable(init.variable).fixed else "state"
                builder.code.add(Comment(f"{origin(init.span)}: {init.variable}"))
                with self._own(builder, factor, init.binders):
                    assigned(init, owner, builder)
        return builder.done("void", self.draw[factor.element])

    def _weigh_start(self, factor: ir.Factor) -> Function:
        """Return how likely one member's initial values make what is seen at the start."""
        builder = self._given_member(self.interface.given(PLACE), factor)
        watches = self._watches(builder, factor, factor.first)
        weight = builder.printer.scope.unique("likelihood")
        builder.code.add(var("double", weight, Literal("1.0")))
        self._weigh(builder, factor, self._first_seen(builder, factor), watches, weight)
        builder.code.add(Return(of(weight)))
        return builder.done("double", self.weigh[factor.element])

    def _move(self, factor: ir.Factor) -> Function:
        """Return what moves one member's values, and gives how likely is what was seen of it."""
        builder = self._given_member(self.interface.acting(_MOVE), factor)
        fields = self.interface.key.reading()
        digits = {
            f.name: digit(builder, member("seen", self.members[f.name]), f.type)
            for f in fields
            if f.name in self.members
        }
        for variable, binders in self._entries(factor):  # an update writes nothing where it keeps a value
            if not variable.fixed:
                with self._own(builder, factor, binders):
                    setter = self.context.names.setters[variable.name]
                    value = self._read(builder, variable, binders, False)
                    given = (*builder.printer.exprs(locals_of(binders)), value)
                    builder.code.add(Do(method("next", setter, *given)))
        for update in self._updates(factor):
            with self._own(builder, factor, update.binders):
                assigned(update, "next", builder)
        weight = builder.printer.scope.unique("likelihood")
        builder.code.add(var("double", weight, Literal("1.0")))
        self._weigh(builder, factor, digits, self.watches[factor.element], weight)
        builder.code.add(Return(of(weight)))
        return builder.done("double", self.move[factor.element])

    def _export(self, factor: ir.Factor) -> Function:
        """Return what writes one member's values as numbers, and gives how many."""
        builder = self._given_member(self.interface.given(_EXPORT), factor)
        first = builder.printer.scope.unique("first")
        builder.code.add(var("double* const", first, "out"))
        for variable, binders in self._entries(factor):
            with self._own(builder, factor, binders):
                value = self._read(builder, variable, binders, False)
                builder.code.add(assign(following("out"), cast("double", value)))
        builder.code.add(Return(cast("int", of("out") - first)))
        return builder.done("int", self.export[factor.element])

    def constants(self) -> list[str]:
        """Return how many numbers ``export_unit`` writes at most."""
        values = [
            sum(length_of(self.model.variable(n).indices) // f.members for n in f.variables)
            for f in self.sampled
        ]
        return [f"static constexpr int kUnitValues = {max(values)};"] if values else []

    def _units(self, builder: Builder, factors: Sequence[ir.Factor], first: int = 0) -> Iterator[ir.Factor]:
        """Yield factors, each inside an ``if`` on ``unit`` that holds for its members; binds the member."""
        for number, factor in enumerate(factors):
            end = first + factor.members
            last = number == len(factors) - 1
            with nullcontext() if last else builder.printer.when(op("unit", "<", end)):
                if factor.binder is not None:
                    builder.printer.bind(MEMBER, value_of(shifted("unit", -first), factor.binder.type))
                yield factor
            if not last:
                builder.code.join()
            first = end
