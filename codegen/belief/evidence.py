# SPDX-License-Identifier: Apache-2.0
"""Evidence: what the agent saw, weighed against a hypothesis about one member of a factor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from hypgen.codegen.belief.hypotheses import MEMBER, Hypotheses, keeps, locals_of
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.cpp.sink import into
from hypgen.codegen.model.interface import Digit
from hypgen.codegen.model.model_functions import arguments, density_needs
from hypgen.codegen.passes.expr_shapes import branches
from hypgen.codegen.passes.guards import Guards
from hypgen.codegen.tree.expr import FALSE, TRUE, Expr, Literal, all_of, call, not_, of, op
from hypgen.codegen.tree.statements import (
    CONTINUE,
    Comment,
    Declare,
    ForEach,
    assign,
    const,
    var,
    when,
    zeroed,
)
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import walk
from hypgen.dsl.types import length_of, low_of


@dataclass(frozen=True)
class Watch:
    """A piece of evidence inside a function that weighs.

    ``touched`` holds the position of the member that an entry touches; None where every entry touches.
    ``direct``: no entry touches another member than its own.
    """

    evidence: ir.Evidence
    touched: Expr | None
    direct: bool


class Weighing(Hypotheses):
    """Prints how likely what was seen is."""

    # Evidence ------------------------------------------------------------------------------------

    def _seen(self, builder: Builder, factors: Sequence[ir.Factor]) -> dict[str, Digit]:
        """Append the digits of the key that the factors' evidence takes."""
        used = {e.name for f in factors for e in f.evidence if e.kind != "end"}
        return self.interface.digits(builder, used) if used else {}

    def _first_seen(self, builder: Builder, factor: ir.Factor) -> dict[str, Digit]:
        """Return what is seen at the start and tells of the factor, given its binders."""
        return {e.name: partial(self.interface.first_value, builder, e.name) for e in factor.first}

    def _watches(
        self, builder: Builder, factor: ir.Factor, pieces: Sequence[ir.Evidence] | None = None
    ) -> list[Watch]:
        """Append which members the evidence touches: that of a step, or ``pieces``."""
        found, printer = [], builder.printer
        for evidence in factor.evidence if pieces is None else pieces:
            direct = _own_entry(evidence.touch, evidence, factor)
            touched: Expr | None = None
            if not direct and not _always(evidence, factor):
                local = printer.scope.unique(told_by(evidence))
                touched = of(local)
                builder.code.add(Comment(_told(evidence, factor)))
                length = length_of(tuple(b.type for b in evidence.binders))
                self._touch(builder, evidence, local, length)
            found.append(Watch(evidence, touched, direct))
        return found

    def _touch(self, builder: Builder, evidence: ir.Evidence, name: str, length: int) -> None:
        code, printer, touch = builder.code, builder.printer, evidence.touch
        if evidence.binders:
            code.add(Declare("std::int32_t", name, dimensions=(length,)))
        elif branches(touch):
            code.add(zeroed("std::int32_t", name))
        else:
            code.add(const("std::int32_t", name, printer.expr(touch)))
            return
        self._set_touch(builder, evidence, of(name))

    def _kept_watch(self, evidence: ir.Evidence, factor: ir.Factor, name: Expr) -> Watch:
        """Return the watch of evidence whose touches are kept under a name."""
        touch = evidence.touch
        if _own_entry(touch, evidence, factor):
            return Watch(evidence, None, True)
        if _always(evidence, factor):
            return Watch(evidence, None, False)
        return Watch(evidence, name, _own_or_none(touch, evidence, factor))

    def _set_touch(self, builder: Builder, evidence: ir.Evidence, touched: Expr) -> None:
        printer = builder.printer
        with printer.loops(evidence.binders):
            entry = touched[_flat(builder, evidence.binders)] if evidence.binders else touched
            printer.emit(evidence.touch, into(entry))

    def _moves(self, builder: Builder, factor: ir.Factor) -> Expr:
        """Return the condition without which no member's values change, and append what it takes."""
        updates = [u for u in self._updates(factor) if not keeps(u)]
        if not updates:
            return FALSE
        guard = Guards(self.model, self.context.needs).update(tuple(updates))
        if guard is None or any(self._is_hidden(node) for node in walk(guard)):
            return TRUE
        moves = builder.printer.scope.unique("moves")
        builder.code.add(const("bool", moves, builder.printer.expr(guard)))
        return of(moves)

    def _is_hidden(self, node: ir.Expr | ir.Dist) -> bool:
        return isinstance(node, ir.StateRead) and not self.model.variable(node.variable).visible

    def _skip(self, builder: Builder, factor: ir.Factor, watches: list[Watch], moves: Expr) -> None:
        """Append what passes over members that nothing moves or touches."""
        touches = [w.touched for w in watches if w.touched is not None]
        if moves == TRUE or len(touches) < len(watches) or factor.binder is None:
            return
        position = self._position(builder, factor)
        tests = [] if moves == FALSE else [moves]
        for watch, touched in zip(watches, touches, strict=True):
            if not watch.evidence.binders:
                tests.append(op(touched, "==", position))
        arrays = [t for w, t in zip(watches, touches, strict=True) if w.evidence.binders]
        code = builder.code
        if not arrays:
            code.add(when(not_(all_of(tests, "||")), CONTINUE) if tests else CONTINUE)
            return
        concerned = builder.printer.scope.unique("concerned")
        code.add(var("bool", concerned, all_of(tests, "||") if tests else FALSE))
        for array in arrays:
            entry = builder.printer.scope.unique("entry")
            with builder.printer.block(ForEach("const std::int32_t", entry, array)):
                code.add(assign(concerned, op(entry, "==", position), "|="))
            code.join()
        code.add(when(not_(concerned), CONTINUE))

    def _weigh(
        self, builder: Builder, factor: ir.Factor, digits: dict[str, Digit], watches: list[Watch], weight: str
    ) -> None:
        """Append the product of how likely what touches the member was."""
        printer = builder.printer
        for watch in watches:
            evidence = watch.evidence
            if watch.direct:
                assert factor.binder is not None
                printer.locals[evidence.binders[0].name] = printer.locals[MEMBER]
            with printer.loops([] if watch.direct else evidence.binders):
                touched = watch.touched
                if touched is None:
                    self._likelihood(builder, evidence, digits, weight)
                    continue
                if evidence.binders:
                    touched = touched[_flat(builder, evidence.binders)]
                position = self._position(builder, factor)
                test = op(touched, ">=", 0) if watch.direct else op(touched, "==", position)
                with printer.when(test):
                    self._likelihood(builder, evidence, digits, weight)
                builder.code.join()

    def _likelihood(
        self, builder: Builder, evidence: ir.Evidence, digits: dict[str, Digit], weight: str
    ) -> None:
        printer, code = builder.printer, builder.code
        if evidence.condition is not None:
            code.add(when(printer.expr(evidence.condition), assign(weight, Literal("0.0"))))
            return
        dist, name = self._law(evidence)
        more = printer.exprs(locals_of(evidence.binders))
        value = digits[evidence.name](evidence.binders)
        given = arguments(density_needs(dist, self.context), self.context, *more, value)
        code.add(assign(weight, call(name, *given), "*="))

    def _law(self, evidence: ir.Evidence) -> tuple[ir.Dist, str]:
        """Return the distribution of what was seen, and the function of its density."""
        parts = self.interface.parts
        if evidence.kind == "first":
            dist = next(i.dist for i in self.model.first_seen if i.variable == evidence.name)
            return dist, parts.init_densities[evidence.name]
        if evidence.kind == "visible":
            dist = next(u.dist for u in self.updates if u.variable == evidence.name)
            return dist, parts.densities[evidence.name]
        dist = next(o.dist for o in self.model.observations if o.name == evidence.name)
        return dist, parts.observation_densities[evidence.name]


def told_by(evidence: ir.Evidence) -> str:
    """Return the name of what holds the member that the evidence tells of."""
    return f"{evidence.name.replace('.', '_') or 'end'}_tells_of"


def _told(evidence: ir.Evidence, factor: ir.Factor) -> str:
    what = evidence.name or "the episode's going on"
    if factor.binder is None:
        return f"0 where {what} tells of {factor.element}, -1 elsewhere."
    return f"The {factor.element} that {what} tells of, or -1."


def _always(evidence: ir.Evidence, factor: ir.Factor) -> bool:
    """Return whether the evidence tells of the one member whatever the agent does."""
    return isinstance(evidence.touch, ir.Const) and evidence.touch.value == 0 and factor.members == 1


def _own_entry(touch: ir.Expr, evidence: ir.Evidence, factor: ir.Factor) -> bool:
    """Return whether the evidence has one entry for each member, which touches that member and no other."""
    if factor.binder is None or len(evidence.binders) != 1 or evidence.binders[0].type != factor.binder.type:
        return False
    binder = evidence.binders[0]
    if isinstance(touch, ir.Binary) and touch.op == "sub" and isinstance(touch.right, ir.Const):
        touch = touch.left if touch.right.value == low_of(binder.type) else touch
    elif low_of(binder.type):
        return False
    return isinstance(touch, ir.Local) and touch.name == binder.name


def _own_or_none(touch: ir.Expr, evidence: ir.Evidence, factor: ir.Factor) -> bool:
    """Return the same for evidence that touches nobody at times."""
    if isinstance(touch, ir.If):
        return all(_own_or_none(t, evidence, factor) for t in (touch.then, touch.otherwise))
    return _nobody(touch) or _own_entry(touch, evidence, factor)


def _nobody(touch: ir.Expr) -> bool:
    return isinstance(touch, ir.Const) and touch.value == -1


def _flat(builder: Builder, binders: Sequence[ir.Binder]) -> Expr:
    return builder.printer.flat(locals_of(binders), [b.type for b in binders])
