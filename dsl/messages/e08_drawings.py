# SPDX-License-Identifier: Apache-2.0
"""Texts of E0813 to E0816: what ``draw`` declarations say wrong about a picture."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span


def unknown_shape(name: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A shape of a name that there is not."""
    remedy = did_you_mean(name, known) or f"shapes are {', '.join(known)}"
    return Diagnostic("E0813", f"there is no shape '{name}'", span, remedy)


def unknown_field(shape: str, name: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A field that a shape does not have."""
    remedy = did_you_mean(name, known) or f"{shape} has {', '.join(known)}"
    return Diagnostic("E0814", f"{shape} has no '{name}'", span, remedy)


def second_field(name: str, span: Span, first: Span) -> Diagnostic:
    """A field that is given twice."""
    note = (first, f"'{name}' is first given here")
    return Diagnostic("E0814", f"'{name}' is given twice", span, "remove one of the two", (note,))


def missing_fields(shape: str, names: Sequence[str], span: Span) -> Diagnostic:
    """Fields that a shape needs and does not have."""
    form = ", ".join(f"{name} = .." for name in names)
    return Diagnostic("E0814", f"{shape} needs {', '.join(names)}", span, f"add {form}")


def text_for_value(name: str, span: Span) -> Diagnostic:
    """A text in quotes for a field that is no text."""
    remedy = "write a colour's name without quotes" if name == "colour" else "write a number"
    return Diagnostic("E0814", f"'{name}' is no text", span, remedy)


def unknown_limits(name: str, axis: str, span: Span) -> Diagnostic:
    """A position of which no limits are known, in a model that declares no area."""
    return Diagnostic(
        "E0815",
        f"how far {axis} of '{name}' goes is not known, and so not what the picture shows",
        span,
        "add a line: draw world = area { x = 0, y = 0, x2 = 10, y2 = 10 }",
    )


def area_with_members(span: Span) -> Diagnostic:
    """An area that is drawn for each value of something."""
    remedy = "leave out the brackets: a picture has one area"
    return Diagnostic("E0816", "an area has no members", span, remedy)


def second_area(span: Span, first: Span) -> Diagnostic:
    """A second area."""
    note = (first, "the first area is here")
    return Diagnostic("E0816", "the picture has a second area", span, "remove one of the two", (note,))


def empty_area(axis: str, low: float, high: float, span: Span) -> Diagnostic:
    """An area whose end does not come after its start."""
    message = f"the area goes from {axis} = {low:g} to {axis} = {high:g}"
    return Diagnostic("E0816", message, span, f"'{axis}2' is larger than '{axis}'")


def outside_area(
    name: str, axis: str, ends: tuple[float, float], area: tuple[float, float], span: Span
) -> Diagnostic:
    """A position that is never in the area."""
    low, high = ends
    found = f"{axis} = {low:g}" if low == high else f"{axis} from {low:g} to {high:g}"
    message = f"'{name}' is never seen: it is at {found}, and the area goes from {area[0]:g} to {area[1]:g}"
    return Diagnostic("E0816", message, span, "correct the position, or make the area larger")
