# SPDX-License-Identifier: Apache-2.0
"""Texts of E0313: units that do not fit, and tables of distances that are not written as such."""

from __future__ import annotations

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import units
from hypgen.dsl.types.units import Unit


def differ(expected: Unit | None, found: Unit | None, verb: str, span: Span, place: Span) -> Diagnostic:
    """Numbers of two units that cannot ``verb`` (``add``); ``place`` is where the first one stands."""
    return Diagnostic(
        "E0313",
        f"{_named(expected)} and {_named(found)} do not {verb}: "
        f"that is {units.described(expected)}, this is {units.described(found)}",
        span,
        _remedy(expected, found),
        ((place, f"this is {units.described(expected)}"),),
    )


def not_plain(what: str, found: Unit, span: Span) -> Diagnostic:
    """A number with a unit where one without is needed."""
    message = f"{what} must be a number without a unit, but this is {units.described(found)}"
    return Diagnostic("E0313", message, span, _remedy(units.PLAIN, found))


def other_unit(what: str, expected: Unit | None, found: Unit | None, span: Span) -> Diagnostic:
    """A number of another unit than the one asked for."""
    message = f"{what} must be {units.described(expected)}, but this is {units.described(found)}"
    return Diagnostic("E0313", message, span, _remedy(expected, found))


def no_root(unit: Unit | None, span: Span) -> Diagnostic:
    """A square root whose unit would have half an exponent."""
    message = f"'sqrt' halves the exponents of a unit, and {units.shown(unit)} has an odd one"
    remedy = "take the root of a square, such as float<m^2>, or strip the unit: sqrt(value(..))"
    return Diagnostic("E0313", message, span, remedy)


def unknown_power(base: Unit | None, span: Span) -> Diagnostic:
    """A power of a number with a unit whose exponent is no constant int."""
    message = f"the unit of this power is not known: the base is {units.described(base)}"
    return Diagnostic("E0313", message, span, "use a constant int as exponent, or strip the unit: value(..)")


def distance_of_other(name: str, span: Span) -> Diagnostic:
    """``distance`` as the value of what is no table over pairs of a type."""
    return Diagnostic(
        "E0313",
        f"'distance' runs over pairs of a type and gives a table of them, which '{name}' is not",
        span,
        "write const d: float[T, T] = distance(a in T, b in T where linked(a, b): cost)",
    )


def distance_without_links(span: Span) -> Diagnostic:
    """``distance`` without a condition."""
    message = "'distance' does not say which values are linked"
    return Diagnostic("E0313", message, span, "write distance(a in T, b in T where linked(a, b): cost)")


def distance_as_value(span: Span) -> Diagnostic:
    """``distance`` within an expression."""
    return Diagnostic(
        "E0313",
        "'distance' gives a whole table, and one value is asked for here",
        span,
        "declare const d: float[T, T] = distance(a in T, b in T where ..) and read d[a, b]",
    )


def _named(unit: Unit | None) -> str:
    return units.shown(unit) or "plain numbers"


def _remedy(expected: Unit | None, found: Unit | None) -> str:
    if not expected:
        return f"divide by a value in {units.shown(found)}, or strip the unit: value(..)"
    if not found:
        return f"declare what this is made of as {units.described(expected)}"
    factor = units.shown(units.product(expected, found, -1))
    return f"a factor in {factor} is missing, or the unit of a part of this; value(..) strips units"
