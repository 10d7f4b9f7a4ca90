"""Fitting a value to the type that its place asks for."""

from __future__ import annotations

from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_same, require_target
from hypgen.dsl.ir.operators import ends, join, measured, to_float
from hypgen.dsl.messages import e03_types
from hypgen.dsl.messages.report import Mistake, mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT32_MAX, INT32_MIN, Float, Int, Type


def check_as(
    node: ast.Expr, scope: Scope, target: Type, what: str = "the value", code: str = "E0601"
) -> ir.Expr:
    """Return ``node`` as a value of ``target``; ``code`` is that of a value that may lie outside."""
    found = scope.check(node, target)
    if scope.open_ints:
        found = assumed(found, target)
    return fit(found, target, node.span, what, code)


def assumed(e: ir.Expr, target: Type) -> ir.Expr:
    """Return an int as the part of its interval that fits ``target``, if any does."""
    if not (isinstance(e.type, Int) and isinstance(target, Int)):
        return e
    low, high = max(e.type.low, target.low), min(e.type.high, target.high)
    return e if low > high or isinstance(e, ir.Const) else replace(e, type=Int(low, high))


def fit(e: ir.Expr, target: Type, span: Span, what: str = "the value", code: str = "E0601") -> ir.Expr:
    """Return ``e`` as a value of ``target``: widened to a float, or proven to lie in the range."""
    found = e.type
    match target, found:
        case Int(low, high), Int(least, most):
            if low <= least and most <= high:
                return e
            raise mistake(
                code,
                f"{what} {lies(least, most)}, which does not fit {low} .. {high}",
                span,
                _range_remedy(e, code, low, high),
            )
        case Int(), Float():
            raise Mistake(e03_types.float_for_int(what, span))
        case Float(_, _, prob, unit), (Int() | Float()):
            require_target(e, target, span, what)
            least_float, most_float = ends(found)
            if prob and (most_float < 0 or least_float > 1):
                raise mistake(
                    "E0606",
                    f"{what} {lies(least_float, most_float)}, which is no probability",
                    span,
                    "a probability lies in 0 .. 1",
                )
            return measured(to_float(e), unit)
    if target == found:
        return e
    raise Mistake(e03_types.mismatch(what, target, found, span))


def unify(branches: list[tuple[ir.Expr, Span]], expected: Type | None) -> list[ir.Expr]:
    """Return branches as one kind: floats if any is, the expected type where that is a float."""
    wide = isinstance(expected, Float) or any(isinstance(e.type, Float) for e, _ in branches)
    if wide and all(isinstance(e.type, Int | Float) for e, _ in branches):
        require_same(branches, "mix in one value")
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
        raise mistake(
            "E0604",
            f"this {lies(e.type.low, e.type.high)}, beyond 32-bit integers",
            span,
            "give the operands smaller types, clamp them, or compute with floats",
        )
    return e


def lies(low: float, high: float) -> str:
    """Return where a value lies, in words."""
    ends = [f"{x:g}" if isinstance(x, float) else str(x) for x in (low, high)]
    return f"is {ends[0]}" if low == high else f"ranges over {' .. '.join(ends)}"


def _range_remedy(e: ir.Expr, code: str, low: int, high: int) -> str:
    if isinstance(e, ir.Const):
        return f"use a value from {low} to {high}"
    if code == "E0602":
        return (
            f"clamp it, clamp(.., {low}, {high}), guard it with a condition, or read at(array, .., default)"
        )
    return f"write clamp(..), wrap(..), checked(..) or clamp(.., {low}, {high}), or guard it with a condition"
