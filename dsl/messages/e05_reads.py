# SPDX-License-Identifier: Apache-2.0
"""Texts of E05xx: what the agent and its policy may know, and what they may not."""

from __future__ import annotations

from collections.abc import Iterable

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span

Note = tuple[Span, str]
_POLICY_ONLY = "use it in the policy or in 'bound lower'; a fn can be given its value"
_MEMORY = "keep what was seen in the policy's memory: memory m: T = first   m' = .. last(reading, first) .."


_LEGAL_BY_BELIEF = (
    "allow the action, and charge for it where it fails: reward fails = if act == .. and .. then -100 else 0;"
    " or keep what was seen in a visible variable, and read that"
)


def hidden_state(
    reader: str, route: str, history: bool, legality: bool, span: Span, notes: Iterable[Note], declared: Note
) -> Diagnostic:
    """A read of hidden state by what the agent must know; ``route`` is the path of reads, in words.

    ``history`` tells whether ``last`` and memory are known there, ``legality`` whether the reader says what
    the agent may do, ``declared`` where the state is declared.
    """
    remedy = _LEGAL_BY_BELIEF if legality else "read visible variables only, or declare this one visible"
    if history:
        remedy = "ask what the agent believes, belief(..), or read visible variables, last(..) and memory"
    message = f"{reader} cannot read hidden state: {route}"
    return Diagnostic("E0501", message, span, remedy, (*notes, declared))


def first_float(what: str, route: str, span: Span, shown: Span) -> Diagnostic:
    """A float that the agent sees at the start, and that follows from a hidden one; ``what`` names it."""
    return _follows("E0502", f"{what} follows from a hidden float at the start: {route}", span, shown)


def _follows(code: str, message: str, span: Span, shown: Span) -> Diagnostic:
    remedy = (
        "no two particles agree on such a value: see it with noise, x ~ normal(.., deviation), "
        "or the bin that it falls into, x ~ binned(..)"
    )
    return Diagnostic(code, message, span, remedy, ((shown, "it is seen here"),))


def draw_of_policy(reader: str, route: str, span: Span, notes: Iterable[Note]) -> Diagnostic:
    """A read of a draw of the policy outside it."""
    message = f"{reader} cannot read a draw of the policy: {route}"
    remedy = "the policy draws only where it is followed; read what came of it, last(action, first)"
    return Diagnostic("E0503", message, span, remedy, tuple(notes))


def draw(reader: str, route: str, span: Span, notes: Iterable[Note]) -> Diagnostic:
    """A read of a draw of a step where no step happens."""
    message = f"{reader} cannot read a draw: {route}"
    remedy = "draws that lets name belong to a step; draw directly, or read the state"
    return Diagnostic("E0503", message, span, remedy, tuple(notes))


def draw_in_memory(name: str, span: Span) -> Diagnostic:
    """Memory whose update draws."""
    message = f"the memory '{name}' cannot draw: it follows from what was seen and done"
    remedy = "write '=' and a value; what the draw led to can be read with last(action, first)"
    return Diagnostic("E0503", message, span, remedy)


def weighed_float(what: str, route: str, span: Span, shown: Span) -> Diagnostic:
    """A float that the agent sees in a step, and that follows from a hidden one or from a draw."""
    return _follows("E0504", f"{what} follows from a hidden float or a draw: {route}", span, shown)


def history_outside_policy(function: str, owner: str, span: Span) -> Diagnostic:
    """``belief``, ``deviation`` or ``last`` outside the policy; ``owner`` is the kind of the declaration."""
    remedy = _LEGAL_BY_BELIEF if owner == "legal" else _POLICY_ONLY
    return Diagnostic("E0505", f"'{function}' is known to the policy only", span, remedy)


def last_action_outside_policy(action: str, owner: str, span: Span) -> Diagnostic:
    """``last(act, ..)`` outside the policy; ``owner`` is the kind of the declaration."""
    remedy = f"let a variable keep it: before' = {action}; in the next step before is what was done"
    if owner == "function":
        remedy = f"let the fn have an argument for it, which the policy gives: f(last({action}, ..))"
    return Diagnostic("E0505", "'last' is known to the policy only", span, remedy)


def policy_outside_policy(name: str, kind: str, span: Span) -> Diagnostic:
    """A let or memory of the policy that is read outside it; ``kind`` says which: ``a let``."""
    message = f"'{name}' is {kind} of the policy, which is not known here"
    remedy = "read it in the policy or in 'bound lower'; a fn can be given its value"
    return Diagnostic("E0505", message, span, remedy)


def belief_of_known(function: str, span: Span) -> Diagnostic:
    """``belief`` or ``deviation`` of what reads nothing hidden."""
    message = f"{function}(..) of something that reads nothing hidden"
    remedy = "its value is known: write it without belief(..)" if function == "belief" else "it is 0"
    return Diagnostic("E0506", message, span, remedy)


def belief_of_vague(function: str, read: str, why: str, form: str, span: Span) -> Diagnostic:
    """``belief`` of what may be one of several members; ``why`` is a clause about the read."""
    return Diagnostic("E0506", f"{function}(..) reads '{read}' {why}", span, f"ask for one at a time: {form}")


def belief_of_members(function: str, read: str, form: str, span: Span) -> Diagnostic:
    """``belief`` of several members of one family."""
    message = f"{function}(..) reads '{read}' of several members of the family"
    return Diagnostic("E0506", message, span, f"ask for one at a time: {form}")


def belief_of_elements(function: str, read: str, other: str, form: str, span: Span) -> Diagnostic:
    """``belief`` of two elements together."""
    message = f"{function}(..) reads '{read}' and '{other}', hidden state of two elements"
    return Diagnostic("E0506", message, span, f"ask for one at a time: {form}")


def belief_of_joint_state(element: str, why: str, span: Span, read: Span) -> Diagnostic:
    """``belief`` of an element whose state is filtered with that of others; ``why`` says by which read."""
    message = f"there is no belief about '{element}' alone: {why}"
    return Diagnostic("E0506", message, span, _MEMORY, ((read, "it is read here"),))


def inexact_belief(element: str, why: str, span: Span) -> Diagnostic:
    """``belief`` of an element without an exact filter."""
    return Diagnostic("E0506", f"there is no exact belief about '{element}': {why}", span, _MEMORY)


def inexact_belief_by_let(element: str, why: str, let: str, span: Span, drawn: Span) -> Diagnostic:
    """``belief`` of an element without an exact filter because a let draws what its update needs."""
    return Diagnostic(
        "E0506",
        f"there is no exact belief about '{element}': {why}",
        span,
        f"draw in the update itself, x' ~ .., in place of the let; or {_MEMORY}",
        ((drawn, f"'{let}' is drawn here"),),
    )


def unmatched_belief(element: str, why: str, span: Span) -> Diagnostic:
    """``belief`` of a float whose mean and deviation are not kept."""
    remedy = (
        "give the float an element of its own, normal or uniform draws, and sensors of its value after the "
        "step, x'; or keep what was seen in memory"
    )
    return Diagnostic("E0506", f"no mean and deviation are kept of '{element}': {why}", span, remedy)


def choice_of_densities(what: str, route: str, span: Span, shown: Span) -> Diagnostic:
    """A float that hidden state makes a value of its own, or one of a continuous law."""
    message = f"hidden state chooses between values and a continuous law of {what}: {route}"
    remedy = (
        "probabilities and densities cannot be compared: see which it is apart, observe lost: bool = .., "
        "and keep to one continuous law"
    )
    return Diagnostic("E0507", message, span, remedy, ((shown, "it is seen here"),))
