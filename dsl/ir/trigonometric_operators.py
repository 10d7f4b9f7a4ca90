"""Building trigonometric expressions: intervals and folded constants, as ``operators`` does for others."""

from __future__ import annotations

import math
from collections.abc import Callable

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.types import Float, intervals
from hypgen.dsl.types.units import PLAIN

PERIODIC: dict[str, Callable[[float], float]] = {"sin": math.sin, "cos": math.cos, "tan": math.tan}
ARCS: dict[str, Callable[[float], float]] = {"asin": math.asin, "acos": math.acos}
_PI = intervals.float32(math.pi)  # the nearest float, which lies above pi


def periodic(op: str, e: ir.Expr) -> ir.Expr:
    """Return ``sin cos tan`` of a number as a float."""
    e = operators.to_float(e)
    found = Float(-math.inf, math.inf) if op == "tan" else Float(-1.0, 1.0)
    return _constant(PERIODIC[op], e) or ir.Unary(found, op, e)


def arc(op: str, e: ir.Expr) -> ir.Expr:
    """Return ``asin acos`` of a number as a float; beyond +-1, where it is NaN, nothing is said of it."""
    e = operators.to_float(e)
    low, high = (min(max(end, -1.0), 1.0) for end in operators.ends(e.type))
    found = intervals.monotone(ARCS[op], (low, high) if op == "asin" else (high, low))  # acos falls
    return _constant(ARCS[op], e) or ir.Unary(operators.numeric(e.type, found), op, e)


def arc_of_point(y: ir.Expr, x: ir.Expr) -> ir.Expr:
    """Return ``atan2(y, x)``: signs of zeros decide at the ends, so that no interval of y or x narrows it."""
    y, x = operators.to_float(y), operators.to_float(x)
    folded = _constant(math.atan2, y, x)
    return (folded and operators.measured(folded, PLAIN)) or ir.Binary(Float(-_PI, _PI), "atan2", y, x)


def _constant(function: Callable[..., float], *operands: ir.Expr) -> ir.Const | None:
    values = [e.value for e in operands if isinstance(e, ir.Const)]
    if len(values) < len(operands):
        return None
    try:
        return operators.real(function(*values))
    except ValueError:  # beyond +-1: NaN, when it is evaluated
        return None
