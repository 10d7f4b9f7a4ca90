# SPDX-License-Identifier: Apache-2.0
"""Refusing what units do not allow: sums of metres and seconds, the sine of a length."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e03_units
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Float, units


def require_same(parts: Sequence[tuple[ir.Expr, Span]], verb: str) -> None:
    """Raise unless all numbers have one unit; ``verb`` is what they cannot do otherwise: ``add``."""
    first, place = next(((e, s) for e, s in parts if operators.unit_of(e) is not None), parts[0])
    expected = operators.unit_of(first)
    for e, span in parts:
        found = operators.unit_of(e)
        if not units.agree(expected, found):
            raise Mistake(e03_units.differ(expected, found, verb, span, place))


def require_plain(e: ir.Expr, span: Span, what: str) -> None:
    """Raise if a number has a unit."""
    unit = operators.unit_of(e)
    if unit:
        raise Mistake(e03_units.not_plain(what, unit, span))


def require_target(e: ir.Expr, target: Float, span: Span, what: str) -> None:
    """Raise unless a number has the unit of the place where it goes."""
    found = operators.unit_of(e)
    if not units.agree(target.unit, found):
        raise Mistake(e03_units.other_unit(what, target.unit, found, span))


def require_root(e: ir.Expr, span: Span) -> None:
    """Raise unless the square root of a number has a unit."""
    unit = operators.unit_of(e)
    if not units.has_root(unit):
        raise Mistake(e03_units.no_root(unit, span))


def require_exponent(base: ir.Expr, exponent: ir.Expr, span: Span) -> None:
    """Raise unless a power's unit is known: that of a value with a unit needs a constant int as exponent."""
    require_plain(exponent, span, "the exponent of '**'")
    whole = isinstance(exponent, ir.Const) and exponent.value == int(exponent.value)
    if operators.unit_of(base) and not whole:
        raise Mistake(e03_units.unknown_power(operators.unit_of(base), span))
