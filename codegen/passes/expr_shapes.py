# SPDX-License-Identifier: Apache-2.0
"""The kind of C++ that an expression becomes: an expression or statements."""

from __future__ import annotations

import math

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import walk
from hypgen.dsl.types import Enum, Float, size_of

# Up to this many values, a loop without a way out is faster than one with it: it unrolls and vectorises.
_PLAIN_LOOP = 64


def needs_statements(*nodes: ir.Expr) -> bool:
    """Return whether C++ has no expression for one of the nodes."""
    return any(isinstance(inner, ir.Quantified | ir.LetIn) for node in nodes for inner in walk(node))


def branches(expr: ir.Expr) -> bool:
    """Return whether ``expr`` is a choice that reads better as statements than as an expression."""
    if not isinstance(expr, ir.If):
        return False
    nested = isinstance(expr.then, ir.If) or isinstance(expr.otherwise, ir.If)
    return nested or needs_statements(expr.then, expr.otherwise)


def plain_variant(enum: Enum, variant: str) -> bool:
    """Return whether a variant of an enum has no argument."""
    found = enum.variant(variant)
    return found is not None and found.argument is None


def plain_loop(expr: ir.Quantified) -> bool:
    """Return whether a loop over a quantifier's values needs no way out before its end."""
    parts = [p for p in (expr.condition, expr.body) if p is not None]
    short = math.prod(size_of(b.type) for b in expr.binders) <= _PLAIN_LOOP
    return short and not needs_statements(*parts)


def is_float_zero(expr: ir.Expr) -> bool:
    """Return whether an expression is the constant 0.0, not -0.0."""
    if not isinstance(expr, ir.Const) or not isinstance(expr.type, Float):
        return False
    return expr.value == 0 and math.copysign(1.0, float(expr.value)) > 0
