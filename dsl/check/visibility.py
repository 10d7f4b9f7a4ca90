"""Rules of who may read what: hidden state, the next state, the action and draws.

The rules follow reads through functions and lets, and a mistake names the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Reach
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.messages.report import Mistake, mistake
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
    "hidden init": Allowance("an init", hidden=True),
    "visible init": Allowance("the init of a visible variable"),
    "invariant": Allowance("an invariant", hidden=True),
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
    if owner.kind == "init":
        variable = variables.get(owner.name)
        kind = "visible init" if variable is not None and variable.visible else "hidden init"
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
        remedy = "state the value without the action"
        if allowed.history:
            remedy = f"it is about to be chosen: last({reach.name}, first) is that of the step before"
        return mistake("E0411", f"{allowed.what} cannot read the action: {route}", reach.span, remedy, notes)
    if reach.kind == "policy draw" and not allowed.own_draws:
        remedy = "the policy draws only where it is followed; read what came of it, last(action, first)"
        message = f"{allowed.what} cannot read a draw of the policy: {route}"
        return mistake("E0503", message, reach.span, remedy, notes)
    if reach.kind == "draw" and not allowed.draws:
        remedy = "draws that lets name belong to a step; draw directly, or read the state"
        return mistake("E0503", f"{allowed.what} cannot read a draw: {route}", reach.span, remedy, notes)
    if reach.kind != "variable" or reach.name not in variables:
        return None
    if reach.primed and not allowed.primed:
        remedy = "remove the prime: there is no next state here"
        return mistake(
            "E0407", f"{allowed.what} cannot read the next state: {route}", reach.span, remedy, notes
        )
    if not variables[reach.name].visible and not allowed.hidden:
        code = "E0502" if owner.kind == "init" else "E0501"
        remedy = "read visible variables only, or declare this one visible"
        if allowed.history:
            remedy = "read visible variables, last(..) and memory, or declare this one visible"
        declared = (variables[reach.name].span, f"'{reach.name}' is declared hidden here")
        message = f"{allowed.what} cannot read hidden state: {route}"
        return mistake(code, message, reach.span, remedy, [*notes, declared])
    return None


def _check_primed_draws(program: Program) -> None:
    """Report primes that would redraw: a draw happens once in a step, before and after are the same."""
    for owner in program.uses.owners():
        for reach in program.uses.closure(owner):
            if reach.kind == "draw" and reach.primed and reach.path[0].primed:
                program.report.add(
                    mistake(
                        "E0704",
                        f"a draw cannot be primed: {reach.route(str(owner))}",
                        reach.span,
                        "remove the prime, or prime the variables alone",
                    )
                )
