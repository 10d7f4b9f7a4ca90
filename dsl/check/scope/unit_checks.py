"""Refusing what units do not allow: sums of metres and seconds, the sine of a length."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.messages.report import mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Float, units

CODE = "E0313"


def require_same(parts: Sequence[tuple[ir.Expr, Span]], verb: str) -> None:
    """Raise unless all numbers have one unit; ``verb`` is what they cannot do otherwise: ``add``."""
    first, place = next(((e, s) for e, s in parts if operators.unit_of(e) is not None), parts[0])
    expected = operators.unit_of(first)
    for e, span in parts:
        found = operators.unit_of(e)
        if not units.agree(expected, found):
            raise mistake(
                CODE,
                f"{_named(expected)} and {_named(found)} do not {verb}: "
                f"that is {units.described(expected)}, this is {units.described(found)}",
                span,
                _remedy(expected, found),
                [(place, f"this is {units.described(expected)}")],
            )


def require_plain(e: ir.Expr, span: Span, what: str) -> None:
    """Raise if a number has a unit."""
    unit = operators.unit_of(e)
    if unit:
        raise mistake(
            CODE,
            f"{what} must be a number without a unit, but this is {units.described(unit)}",
            span,
            _remedy(units.PLAIN, unit),
        )


def require_target(e: ir.Expr, target: Float, span: Span, what: str) -> None:
    """Raise unless a number has the unit of the place where it goes."""
    found = operators.unit_of(e)
    if not units.agree(target.unit, found):
        raise mistake(
            CODE,
            f"{what} must be {units.described(target.unit)}, but this is {units.described(found)}",
            span,
            _remedy(target.unit, found),
        )


def require_root(e: ir.Expr, span: Span) -> None:
    """Raise unless the square root of a number has a unit."""
    unit = operators.unit_of(e)
    if not units.has_root(unit):
        raise mistake(
            CODE,
            f"'sqrt' halves the exponents of a unit, and {units.shown(unit)} has an odd one",
            span,
            "take the root of a square, such as float<m^2>, or strip the unit: sqrt(value(..))",
        )


def require_exponent(base: ir.Expr, exponent: ir.Expr, span: Span) -> None:
    """Raise unless a power's unit is known: that of a value with a unit needs a constant int as exponent."""
    require_plain(exponent, span, "the exponent of '**'")
    whole = isinstance(exponent, ir.Const) and exponent.value == int(exponent.value)
    if operators.unit_of(base) and not whole:
        raise mistake(
            CODE,
            f"the unit of this power is not known: the base is {units.described(operators.unit_of(base))}",
            span,
            "use a constant int as exponent, or strip the unit: value(..)",
        )


def _named(unit: units.Unit | None) -> str:
    return units.shown(unit) or "plain numbers"


def _remedy(expected: units.Unit | None, found: units.Unit | None) -> str:
    if not expected:
        return f"divide by a value in {units.shown(found)}, or strip the unit: value(..)"
    if not found:
        return f"declare what this is made of as {units.described(expected)}"
    return f"convert it to {units.shown(expected)}, or strip the units: value(..)"
