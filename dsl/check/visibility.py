# SPDX-License-Identifier: Apache-2.0
"""Rules of who may read what: hidden state, the next state, the action and draws.

The rules follow reads through functions and lets, and a mistake names the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Reach
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.messages import e04_variables, e05_reads, e07_draws
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span


@dataclass(frozen=True)
class Allowance:
    """What a kind of declaration may read besides params and unprimed visible state.

    ``history``: memory and ``last(..)`` too; ``own_draws``: the draws of the policy.
    """

    what: str
    hidden: bool = False
    primed: bool = False
    action: bool = False
    draws: bool = False
    history: bool = False
    own_draws: bool = False


_EVERYTHING = {"hidden": True, "primed": True, "action": True, "draws": True}
_ALLOWED = {
    "policy": Allowance("the default policy", history=True, own_draws=True),
    "policy let": Allowance("the default policy", history=True, own_draws=True),
    "first memory": Allowance("the first value of a policy's memory"),
    "next memory": Allowance("the update of a policy's memory", history=True),
    "legal": Allowance("'legal when'", action=True),
    "bound upper": Allowance("bound upper", hidden=True),
    "bound tail": Allowance("bound tail", hidden=True),
    "bound lower": Allowance("bound lower", history=True),
    "init": Allowance("an init", hidden=True),
    "invariant": Allowance("an invariant", hidden=True),
    "draw": Allowance("what is drawn", hidden=True),
    "step": Allowance("a step", **_EVERYTHING),
}


def check_reads(program: Program, variables: dict[str, ir.Variable], owners: list[Owner]) -> None:
    """Report what each of ``owners`` reads and must not."""
    for owner in owners:
        allowed = _allowance(owner, variables)
        reported: set[tuple[str, Span]] = set()
        for reach in program.uses.closure(owner):
            if _told_at_let(reach):
                continue
            error = _refusal(owner, allowed, reach, variables)
            if error is None:
                continue
            key = (error.diagnostics[0].code, reach.span)
            if key not in reported:
                reported.add(key)
                program.report.add(error)
    _check_primed_draws(program)


def _allowance(owner: Owner, variables: dict[str, ir.Variable]) -> Allowance:
    kind: str = owner.kind
    if owner.asker is not None:
        return replace(_allowance(owner.asker, variables), what="a belief", hidden=True)
    if owner.kind == "bound":
        kind = f"bound {owner.name}"
    return _ALLOWED.get(kind, _ALLOWED["step"])


def _told_at_let(reach: Reach) -> bool:
    """Return whether a let of the policy leads to the read, which is then checked as the let's own."""
    of_policy = [u.kind in ("policy let", "policy draw") for u in reach.path]
    return any(of_policy) and not of_policy[-1]


def _refusal(
    owner: Owner, allowed: Allowance, reach: Reach, variables: dict[str, ir.Variable]
) -> Mistake | None:
    route = reach.route(str(owner) if owner.asker is None else f"a belief in {owner.asker}")
    notes = [(reach.path[-1].span, f"'{reach.name}' is read here")] if len(reach.path) > 1 else []
    if reach.kind == "action" and not allowed.action:
        return Mistake(
            e04_variables.action_unknown(allowed.what, route, reach.name, allowed.history, reach.span, notes)
        )
    if reach.kind == "policy draw" and not allowed.own_draws:
        return Mistake(e05_reads.draw_of_policy(allowed.what, route, reach.span, notes))
    if reach.kind == "draw" and not allowed.draws:
        return Mistake(e05_reads.draw(allowed.what, route, reach.span, notes))
    if reach.kind != "variable" or reach.name not in variables:
        return None
    if reach.primed and not allowed.primed:
        return Mistake(e04_variables.next_state_unknown(allowed.what, route, reach.span, notes))
    if not variables[reach.name].visible and not allowed.hidden:
        declared = (variables[reach.name].span, f"'{reach.name}' is declared hidden here")
        legality = owner.kind == "legal"
        return Mistake(
            e05_reads.hidden_state(
                allowed.what, route, allowed.history, legality, reach.span, notes, declared
            )
        )
    return None


def _check_primed_draws(program: Program) -> None:
    """Report primes that would redraw: a draw happens once in a step, before and after are the same."""
    for owner in program.uses.owners():
        for reach in program.uses.closure(owner):
            if reach.kind == "draw" and reach.primed and reach.path[0].primed:
                program.report.add(
                    Mistake(e07_draws.primed_read_of_draw(reach.route(str(owner)), reach.span))
                )
