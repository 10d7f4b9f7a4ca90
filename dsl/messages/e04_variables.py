# SPDX-License-Identifier: Apache-2.0
"""Texts of E04xx: inits, updates and memory, and which values they may read in a step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span

Note = tuple[Span, str]


def no_update(path: str, name: str, span: Span) -> Diagnostic:
    """A variable that is not fixed and has no update; ``path`` names its element too."""
    remedy = f"add: {name}' = .., or declare it fixed if it never changes"
    return Diagnostic("E0401", f"'{path}' has no update", span, remedy)


def no_update_of_memory(name: str, kept: str, span: Span) -> Diagnostic:
    """Memory without an update; ``kept`` is the update that changes nothing."""
    remedy = f"add: {name}' = ..; to keep what it holds, {kept}"
    return Diagnostic("E0401", f"the memory '{name}' has no update", span, remedy)


def update_of_fixed(path: str, span: Span, declared: Span) -> Diagnostic:
    """An update of a variable that is declared fixed."""
    return Diagnostic(
        "E0402",
        f"'{path}' is fixed but has an update",
        span,
        "remove 'fixed' or the update",
        ((declared, "it is declared fixed here"),),
    )


def second_assignment(path: str, kind: str, span: Span, first: Span) -> Diagnostic:
    """A variable's second ``init`` or ``update``."""
    return Diagnostic(
        "E0403",
        f"'{path}' has a second {kind}",
        span,
        "a variable has one: join the two with if .. then .. else",
        ((first, f"the first {kind} is here"),),
    )


def second_update_of_memory(name: str, span: Span, first: Span) -> Diagnostic:
    """A second update of memory."""
    return Diagnostic(
        "E0403",
        f"'{name}' has a second update",
        span,
        "join the two with if .. then .. else",
        ((first, "the first update is here"),),
    )


def no_init(path: str, name: str, span: Span) -> Diagnostic:
    """A variable without an init."""
    return Diagnostic("E0404", f"'{path}' has no init", span, f"add: init {name} = .., or ~ a draw")


def circular_updates(cycle: Sequence[str], span: Span, reads: Sequence[Span]) -> Diagnostic:
    """Updates that need each other's new values; ``reads`` are where each needs the next one."""
    following = [*cycle[1:], cycle[0]]
    path = " -> ".join(f"{name}'" for name in [*cycle, cycle[0]])
    return Diagnostic(
        "E0405",
        f"the updates need each other: {path}",
        span,
        "read the value before the step, without the prime, at one of these places",
        tuple(
            (read, f"'{name}'' needs '{other}'' here")
            for name, other, read in zip(cycle, following, reads, strict=True)
        ),
    )


def circular_inits(cycle: Sequence[str], span: Span, reads: Sequence[Span]) -> Diagnostic:
    """Inits that need each other's values; ``reads`` are where each needs the next one."""
    following = [*cycle[1:], cycle[0]]
    message = f"the inits need each other: {' -> '.join([*cycle, cycle[0]])}"
    if len(cycle) == 1:
        message = f"the init of '{cycle[0]}' reads '{cycle[0]}' itself, which has no value yet"
    return Diagnostic(
        "E0406",
        message,
        span,
        "draw one of them without the other",
        tuple(
            (read, f"'{name}' needs '{other}' here")
            for name, other, read in zip(cycle, following, reads, strict=True)
        ),
    )


def next_belief(function: str, span: Span) -> Diagnostic:
    """A primed ``belief`` or ``deviation``."""
    return Diagnostic("E0407", f"a {function} has no next value", span, "remove the prime")


def next_last(span: Span) -> Diagnostic:
    """A primed ``last``."""
    return Diagnostic("E0407", "the past has no next value", span, "remove the prime")


def next_of_policy(name: str, span: Span) -> Diagnostic:
    """A primed let or memory of the policy."""
    remedy = "remove the prime; to use what memory will hold, name it with a let"
    return Diagnostic("E0407", f"'{name}' has no next value here", span, remedy)


def next_state_unknown(reader: str, route: str, span: Span, notes: Iterable[Note]) -> Diagnostic:
    """A prime where there is no next state; ``route`` is the path of reads, in words."""
    message = f"{reader} cannot read the next state: {route}"
    return Diagnostic("E0407", message, span, "remove the prime: there is no next state here", tuple(notes))


def primed_twice(span: Span) -> Diagnostic:
    """A prime within what is primed."""
    remedy = "one prime already reads the next state: remove one"
    return Diagnostic("E0408", "this is primed twice", span, remedy)


def idle_prime(span: Span) -> Diagnostic:
    """A prime of what no step changes."""
    return Diagnostic(
        "E0409",
        "the prime has no effect: nothing here is state",
        span,
        "remove the prime; only variables, and what reads them, change in a step",
    )


def assigned_in_element(element: str, name: str, known: Iterable[str], other: str, span: Span) -> Diagnostic:
    """An init or update of what is no variable of the element.

    ``known`` are its variables; ``other`` is the remedy where none has a similar name.
    """
    message = f"element '{element}' has no variable '{name}'"
    return Diagnostic("E0410", message, span, did_you_mean(name, known) or other)


def assigned_in_policy(name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """An update in the policy of what is no memory; ``known`` is the memory that there is."""
    remedy = did_you_mean(name, known) or f"declare it: memory {name}: type = first"
    return Diagnostic("E0410", f"the policy has no memory '{name}'", span, remedy)


def action_unknown(
    reader: str, route: str, action: str, history: bool, span: Span, notes: Iterable[Note]
) -> Diagnostic:
    """A read of the action where none is chosen; ``history`` tells whether the last one is known."""
    remedy = "state the value without the action"
    if history:
        remedy = f"it is about to be chosen: last({action}, first) is that of the step before"
    return Diagnostic("E0411", f"{reader} cannot read the action: {route}", span, remedy, tuple(notes))


def unordered_inits(name: str, other: str, span: Span, read: Span | None) -> Diagnostic:
    """An init that reads members of a family without a value yet; ``read`` is where, if not at ``span``."""
    return Diagnostic(
        "E0412",
        f"the init of '{name}' reads '{other}' of members that may have no value yet",
        span,
        "members get their values in order: read lower ones only, as in all(j in T where j < i: ..)",
        () if read is None else ((read, f"'{other}' is read here"),),
    )
