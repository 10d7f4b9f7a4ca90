# SPDX-License-Identifier: Apache-2.0
"""Building trigonometric expressions: intervals and folded constants, as ``operators`` does for others."""

from __future__ import annotations

import math

from hypgen.dsl import ir
from hypgen.dsl.ir import evaluate, operators
from hypgen.dsl.types import Float, intervals
from hypgen.dsl.types.units import PLAIN

PERIODIC = ("sin", "cos", "tan")
ARCS = ("asin", "acos")
_PI = intervals.float32(math.pi)  # the nearest float, which lies above pi


def periodic(op: str, e: ir.Expr) -> ir.Expr:
    """Return ``sin cos tan`` of a number as a float."""
    e = operators.to_float(e)
    found = Float(-math.inf, math.inf) if op == "tan" else Float(-1.0, 1.0)
    return operators.folded(op, None, e) or ir.Unary(found, op, e)


def arc(op: str, e: ir.Expr) -> ir.Expr:
    """Return ``asin acos`` of a number as a float; beyond +-1, where it is NaN, nothing is said of it."""
    e = operators.to_float(e)
    low, high = (min(max(end, -1.0), 1.0) for end in operators.ends(e.type))
    rising = (low, high) if op == "asin" else (high, low)  # acos falls
    found = intervals.monotone(evaluate.OPERATORS[op], rising)
    return operators.folded(op, None, e) or ir.Unary(operators.numeric(e.type, found), op, e)


def arc_of_point(y: ir.Expr, x: ir.Expr) -> ir.Expr:
    """Return ``atan2(y, x)``: signs of zeros decide at the ends, so that no interval of y or x narrows it."""
    y, x = operators.to_float(y), operators.to_float(x)
    return operators.folded("atan2", PLAIN, y, x) or ir.Binary(Float(-_PI, _PI), "atan2", y, x)
