# SPDX-License-Identifier: Apache-2.0
"""Texts of E0305, E0306 and E0307: patterns of ``match`` that are missing, in vain or impossible."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Bool, Enum, Int


def no_arms(span: Span) -> Diagnostic:
    """A ``match`` without patterns."""
    return Diagnostic("E0305", "'match' has no arms", span, "add 'pattern => value'")


def left_out(missing: Sequence[str], span: Span) -> Diagnostic:
    """Values that no pattern covers."""
    remedy = "add an arm for each, or 'else => ..'"
    return Diagnostic("E0305", f"'match' leaves out {', '.join(missing)}", span, remedy)


def behind_else(span: Span) -> Diagnostic:
    """A pattern behind ``else``."""
    message = "this arm is never reached: 'else' comes before it"
    return Diagnostic("E0306", message, span, "move 'else' to the end")


def covered_before(pattern: str, span: Span) -> Diagnostic:
    """A pattern that stands twice."""
    message = f"this arm is never reached: '{pattern}' comes before it"
    return Diagnostic("E0306", message, span, "remove one of the two")


def not_a_variant(enum: Enum, span: Span) -> Diagnostic:
    """A number or a bool among an enum's patterns."""
    return Diagnostic("E0307", f"this matches values of {enum}", span, "name one of its variants")


def variant_without_argument(name: str, span: Span) -> Diagnostic:
    """A pattern that names the argument of a variant without one."""
    return Diagnostic("E0307", f"variant '{name}' has no argument", span, f"write {name} alone")


def value_as_name(variant: str, value: str, enum: Enum, span: Span) -> Diagnostic:
    """A pattern ``move(up)`` that would give the argument the name of one of its values."""
    message = f"a pattern names what '{variant}' carries, and '{value}' is a value of {enum}"
    remedy = f"write {variant}(a) => match a {{ {value} => ..  else => .. }}"
    return Diagnostic("E0307", message, span, remedy)


def argument_of_alternatives(span: Span) -> Diagnostic:
    """An arm of several patterns that names an argument."""
    message = "an arm with alternatives cannot name an argument"
    return Diagnostic("E0307", message, span, "write one arm for each alternative")


def other_kind(matched: Bool | Int, span: Span) -> Diagnostic:
    """A pattern of another type than the value."""
    wanted = "true or false" if isinstance(matched, Bool) else "integers"
    return Diagnostic("E0307", f"this matches {wanted}", span, f"use {wanted} as patterns")


def never_occurs(number: int, matched: Int, span: Span) -> Diagnostic:
    """A number outside the range of the value."""
    message = f"{number} never occurs: the value ranges over {matched}"
    return Diagnostic("E0307", message, span, "remove this pattern")
