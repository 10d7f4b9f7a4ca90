# SPDX-License-Identifier: Apache-2.0
"""Texts of E0901 to E0912 about files in Cassandra's format."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import counted

FORM = "write `T : action : state : next-state probability`, and `O` and `R` likewise"
MISSING_NUMBERS = "give the numbers that are missing"


def number_remedy(word: str) -> str:
    """Return what to write instead of a word where numbers are expected."""
    return did_you_mean(word.lower(), ("identity", "uniform", "reset")) or "write a number, such as 0.25"


def early_end(what: str, span: Span) -> Diagnostic:
    """The end of the file where ``what`` is expected."""
    return Diagnostic("E0901", f"{what} is expected, but the file ends", span, "complete the file")


def unexpected(what: str, found: str, remedy: str, span: Span) -> Diagnostic:
    """Another word where ``what`` is expected."""
    found = found if len(found) <= 30 else found[:27] + "..."
    return Diagnostic("E0901", f"{what} is expected, but found '{found}'", span, remedy)


def unknown_specification(found: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A word that starts no specification."""
    remedy = did_you_mean(found.lower(), known)
    remedy = remedy or "a specification starts with T, O, R or a word as `discount:`, a comment with #"
    return Diagnostic("E0901", f"a specification is expected, but found '{found[:30]}'", span, remedy)


def unknown_number(what: str, number: str, size: int, span: Span) -> Diagnostic:
    """A state, action or observation by a number that is too large."""
    message = f"there is no {what} {number}: they are numbered 0 to {size - 1}"
    return Diagnostic("E0902", message, span, "correct the number")


def unknown_name(what: str, name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A state, action or observation by a name that is not declared."""
    remedy = did_you_mean(name, known) or f"declare it, or use one of the {what}s declared above"
    return Diagnostic("E0902", f"there is no {what} called '{name[:30]}'", span, remedy)


def number_too_many(taken: str, span: Span) -> Diagnostic:
    """A number behind all that a specification takes; ``taken`` says what it takes."""
    message = f"here is a number too many: {taken}"
    return Diagnostic("E0903", message, span, "remove it, or one before it")


def numbers_missing(what: str, count: int, has: int, at_end: bool, remedy: str, span: Span) -> Diagnostic:
    """Fewer numbers than a specification takes; ``at_end`` tells whether the file ends there."""
    end = "the file ends" if at_end else "the next specification starts"
    message = f"{what} takes {counted(count, 'number')}, but {end} after {has}"
    return Diagnostic("E0903", message, span, remedy)


def reset_of_matrix(table: str, span: Span) -> Diagnostic:
    """``reset`` for all rows of an action at once."""
    if table != "T":
        return Diagnostic("E0901", "'reset' stands for a row of T", span, "give the matrix")
    remedy = "write `T : action : *` and then `reset`, or `T : action : state` for one row"
    return Diagnostic("E0901", "'reset' stands for a row, not for a whole matrix", span, remedy)


def reward_sees_nothing(span: Span) -> Diagnostic:
    """A fourth field of R in a file that declares no observations."""
    message = "R takes an action, a state and a next state here, as the file declares no observations"
    return Diagnostic("E0901", message, span, "write `R : action : state : next state number`")


def not_square(values: str, span: Span) -> Diagnostic:
    """``identity`` for a matrix with as many columns as there are ``values``, not states."""
    message = f"'identity' needs as many {values}s as states"
    return Diagnostic("E0903", message, span, "give the matrix")


def wrong_start(states: int, has: int, span: Span) -> Diagnostic:
    """A start with another number of probabilities than there are states."""
    message = f"'start' takes {states} numbers, one for each state, but {has} are given"
    return Diagnostic("E0903", message, span, "give one for each state")


def no_start(span: Span) -> Diagnostic:
    """A start that excludes every state."""
    return Diagnostic("E0904", "no state is left to start in", span, "exclude fewer")


def negative_start(probability: float, span: Span) -> Diagnostic:
    """A negative probability of the start."""
    message = f"a probability of the start is {probability:g}"
    return Diagnostic("E0904", message, span, "make them sum to 1")


def rows_missing(rows: Sequence[str], span: Span) -> Diagnostic:
    """Rows without any probability."""
    shown = ", ".join(rows[:3]) + (f" and {len(rows) - 3} more" if len(rows) > 3 else "")
    message = f"{len(rows)} {'row has' if len(rows) == 1 else 'rows have'} no probabilities: {shown}"
    return Diagnostic("E0905", message, span, "give what happens in each state under each action")


def no_probability(number: float, span: Span) -> Diagnostic:
    """A number outside 0 .. 1 where a probability is expected."""
    return Diagnostic("E0906", f"{number:g} is no probability", span, "give one from 0 to 1")


def declared_twice(kind: str, span: Span) -> Diagnostic:
    """A second declaration of the states, actions or observations."""
    remedy = "keep one declaration, before the tables"
    return Diagnostic("E0907", f"the {kind} are declared twice", span, remedy)


def declared_late(kind: str, span: Span) -> Diagnostic:
    """A declaration of the states, actions or observations behind the first table."""
    remedy = "keep one declaration, before the tables"
    return Diagnostic("E0907", f"the {kind} are declared after T, O or R", span, remedy)


def duplicate_name(what: str, name: str, span: Span) -> Diagnostic:
    """A state, action or observation whose name is taken."""
    message = f"the {what} '{name}' is declared twice"
    return Diagnostic("E0907", message, span, "give each a name of its own")


def not_declared(kind: str, span: Span) -> Diagnostic:
    """A table without the declaration of its states, actions or observations."""
    remedy = f"add `{kind}: ` and their number or names above the tables"
    return Diagnostic("E0907", f"the {kind} are not declared", span, remedy)


def wrong_discount(discount: float, span: Span) -> Diagnostic:
    """A discount outside 0 .. 1."""
    return Diagnostic("E0908", f"the discount is {discount:g}", span, "give one from 0 to 1")


def wrong_size(kind: str, size: int, most: int, span: Span) -> Diagnostic:
    """No states, actions or observations, or more than can be imported."""
    message = f"there are {size} {kind}, and 1 to {most} can be imported"
    return Diagnostic("E0912", message, span, "make the model smaller")


def many_rows(states: int, actions: int, most: int, span: Span) -> Diagnostic:
    """More rows of a table than can be imported."""
    message = f"{states} states times {actions} actions are more than {most} rows"
    return Diagnostic("E0912", message, span, "make the model smaller")


def many_rewrites(span: Span) -> Diagnostic:
    """Specifications that write too many entries, those that are written again included."""
    message = "specifications with '*' write millions of entries again and again"
    return Diagnostic("E0912", message, span, "write each entry once")
