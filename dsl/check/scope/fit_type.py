# SPDX-License-Identifier: Apache-2.0
"""Fitting a value to the type that its place asks for."""

from __future__ import annotations

from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_same, require_target
from hypgen.dsl.ir.operators import ends, join, measured, to_float, unit_of
from hypgen.dsl.messages import e03_types, e06_ranges
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT32_MAX, INT32_MIN, Float, Int, Type, units


def check_as(
    node: ast.Expr, scope: Scope, target: Type, what: str = "the value", *, is_index: bool = False
) -> ir.Expr:
    """Return ``node`` as a value of ``target``; ``is_index`` tells whether it is an array's index."""
    found = scope.check(node, target)
    if scope.open_ints:
        found = assumed(found, target)
    return fit(found, target, node.span, what, is_index=is_index)


def assumed(e: ir.Expr, target: Type) -> ir.Expr:
    """Return an int as the part of its interval that fits ``target``, if any does."""
    if not (isinstance(e.type, Int) and isinstance(target, Int)):
        return e
    low, high = max(e.type.low, target.low), min(e.type.high, target.high)
    return e if low > high or isinstance(e, ir.Const) else replace(e, type=Int(low, high))


def fit(e: ir.Expr, target: Type, span: Span, what: str = "the value", *, is_index: bool = False) -> ir.Expr:
    """Return ``e`` as a value of ``target``: widened to a float, or proven to lie in the range."""
    found = e.type
    match target, found:
        case Int(low, high), Int(least, most):
            if low <= least and most <= high:
                return e
            outside = e06_ranges.index_outside_range if is_index else e06_ranges.outside_range
            raise Mistake(outside(what, found, target, isinstance(e, ir.Const), span))
        case Int(), Float():
            raise Mistake(e03_types.float_for_int(what, span, is_index))
        case Float(_, _, prob, unit), (Int() | Float()):
            require_target(e, target, span, what)
            least_float, most_float = ends(found)
            if prob and (most_float < 0 or least_float > 1):
                raise Mistake(e06_ranges.no_probability(what, least_float, most_float, span))
            return measured(to_float(e), unit)
    if target == found:
        return e
    raise Mistake(e03_types.mismatch(what, target, found, span))


def unify(branches: list[tuple[ir.Expr, Span]], expected: Type | None) -> list[ir.Expr]:
    """Return branches as one kind: floats if any is, the expected type where that is a float."""
    wide = isinstance(expected, Float) or any(isinstance(e.type, Float) for e, _ in branches)
    if wide and all(isinstance(e.type, Int | Float) for e, _ in branches):
        # The branch that has another unit than the place where the value goes is the wrong one.
        right = expected.unit if isinstance(expected, Float) else None
        first = sorted(branches, key=lambda branch: not units.agree(right, unit_of(branch[0])))
        require_same(first, "mix in one value")
    result: list[ir.Expr] = []
    for e, span in branches:
        e = to_float(e) if wide and isinstance(e.type, Int) else e
        if result and join(result[0].type, e.type) is None:
            raise Mistake(e03_types.branches_differ(result[0].type, e.type, span, branches[0][1]))
        result.append(e)
    return result


def require_int32(e: ir.Expr, span: Span) -> ir.Expr:
    """Return ``e``, or raise if its interval leaves int32."""
    if isinstance(e.type, Int) and (e.type.low < INT32_MIN or e.type.high > INT32_MAX):
        raise Mistake(e06_ranges.beyond_int32(e.type, span))
    return e
