# SPDX-License-Identifier: Apache-2.0
"""Draws made from other draws: ``truncated``, ``clamp`` and ``binned``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.draws.fit_distribution import changed, fitted
from hypgen.dsl.check.draws.number_draws import MOST_COUNT, continuous, interval, numbers
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_same
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e03_types, e06_ranges, e07_draws, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT, INT32_MAX, Float, Int, Type, is_finite


def truncated(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``truncated(D, low, high)``: D given that it lies between the ends."""
    drawn = node.arguments[0]
    dist = scope.draw(drawn, None, what)
    if isinstance(dist.type, Int):
        ends = gather([partial(_constant_end, n, scope, INT) for n in node.arguments[1:]])
        low, high = (int(e.value) for e in ends)
        _refuse_empty(low > high, node)
        return fitted(
            changed(dist, partial(_truncated_count, low, high, drawn.span)), target, node.span, what
        )
    least, most = _float_ends(node, dist, scope)
    found = changed(dist, partial(_truncated_float, least, most, drawn.span))
    return continuous(found, target, node.span, what)


def _float_ends(node: ast.Call, dist: ir.Dist, scope: Scope) -> tuple[ir.Expr, ir.Expr]:
    """Return the ends as floats of the unit in which ``dist`` draws."""
    low, high = numbers(node, ("the lower end", "the upper end"), scope)
    _refuse_empty(operators.ends(low.type)[0] >= operators.ends(high.type)[1], node)
    drawn = (ir.Local(dist.type, ""), node.arguments[0].span)
    if isinstance(dist.type, Float):
        given = [(e, n.span) for e, n in zip((low, high), node.arguments[1:], strict=True)]
        require_same([drawn, *given], f"go together in '{node.name}'")
    return operators.to_float(low), operators.to_float(high)


def _refuse_empty(empty: bool, node: ast.Call) -> None:
    if empty:
        raise Mistake(e06_ranges.ends_not_apart(node.name, node.span))


def _constant_end(node: ast.Expr, scope: Scope, t: Type) -> ir.Const:
    e = check_as(node, scope, t, "an end")
    if not isinstance(e, ir.Const):
        raise Mistake(e08_parts.end_of_draw_not_constant(node.span))
    return e


def _truncated_count(low: int, high: int, span: Span, dist: ir.Dist) -> ir.Dist:
    match dist:
        case ir.Poisson(Int(_, most)) | ir.Binomial(Int(_, most)) if _is_whole(dist):
            first, last = max(low, 0), min(high, most)
            if first <= last and isinstance(dist, ir.Poisson):
                _refuse_many(last, span)
            if first <= last:
                return replace(dist, type=Int(first, last), first=first, last=last)
        case ir.Uniform(Int(least, most)):
            if max(low, least) <= min(high, most):
                return ir.Uniform(Int(max(low, least), min(high, most)))
        case ir.UniformInt(Int(least, most), a, b) if _is_whole(dist):
            if max(low, least) <= min(high, most):
                a = operators.arithmetic("max", a, operators.integer(low))
                b = operators.arithmetic("min", b, operators.integer(high))
                assert isinstance(a.type, Int) and isinstance(b.type, Int)
                return ir.UniformInt(Int(max(low, least), min(high, most)), a, b)
        case _:
            raise Mistake(e07_draws.not_truncated(span))
    raise Mistake(e06_ranges.nothing_left(low, high, span))


def _is_whole(dist: ir.Dist) -> bool:
    """Return whether the law is as its call gave it, not yet truncated or clamped."""
    match dist:
        case ir.Poisson(Int(_, most)):
            return most == INT32_MAX
        case ir.Binomial(Int(_, most), _, last, trials):
            return last is None and most == operators.ends(trials.type)[1]
        case ir.UniformInt(Int() as t, low, high):
            (least, lower), (_, upper) = operators.ends(low.type), operators.ends(high.type)
            return (t.low, t.high) == (least, max(lower, upper))
    return False


def _truncated_float(low: ir.Expr, high: ir.Expr, span: Span, dist: ir.Dist) -> ir.Dist:
    ends = operators.ends(low.type)[0], operators.ends(high.type)[1]
    t = interval(*ends, ir.Local(dist.type, ""), low, high)
    match dist:
        case ir.Normal() | ir.Exponential():
            return ir.Truncated(t, dist, low, high)
        case ir.UniformFloat(_, a, b):
            a, b = operators.arithmetic("max", a, low), operators.arithmetic("min", b, high)
            return ir.UniformFloat(t, a, b)
    raise Mistake(e07_draws.not_truncated(span))


def _refuse_many(last: int, span: Span) -> None:
    if last > MOST_COUNT:
        raise Mistake(e06_ranges.many_counts(last, MOST_COUNT, span))


def clamped(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``clamp(D)`` or ``clamp(D, low, high)``: what D draws, forced into the range."""
    drawn = node.arguments[0]
    dist = scope.draw(drawn, None, what)
    low, high = _range(node, scope, target, dist.type)
    if isinstance(dist.type, Float):
        limit = partial(_clamped_float, low, high, drawn.span)
        return continuous(changed(dist, limit), target, node.span, what)
    limit = partial(_clamped_int, int(low), int(high), drawn.span)
    return fitted(changed(dist, limit), target, node.span, what)


def _range(node: ast.Call, scope: Scope, target: Type | None, found: Type) -> tuple[float, float]:
    """Return the ends that a clamp gives, or those of the type that is asked for."""
    if len(node.arguments) == 1:
        return _range_of(target, found, node.span)
    kind = replace(found, prob=False) if isinstance(found, Float) else INT
    low, high = gather([partial(_constant_end, n, scope, kind) for n in node.arguments[1:]])
    if low.value > high.value:
        raise Mistake(e06_ranges.swapped_ends("clamp", node.span))
    return float(low.value), float(high.value)


def _range_of(target: Type | None, found: Type, span: Span) -> tuple[float, float]:
    if isinstance(target, Int) and isinstance(found, Int) and is_finite(target):
        return target.low, target.high
    if isinstance(target, Float) and isinstance(found, Float) and target.prob:
        return target.low, target.high
    if isinstance(target, Int) and isinstance(found, Float):
        continuous(ir.Certain(found, operators.real(0.0)), target, span, "the value")
    raise Mistake(e03_types.no_ends_of_draw(span))


def _clamped_float(low: float, high: float, span: Span, dist: ir.Dist) -> ir.Dist:
    match dist:
        case ir.Certain(_, value):
            e = operators.clamp(value, low, high)
            return ir.Certain(e.type, e)
        case ir.Clamped(_, law, first, last):
            ends = (min(max(end, low), high) for end in (first, last))
            return ir.Clamped(interval(low, high, ir.Local(dist.type, "")), law, *ends)
        case ir.Continuous():
            return ir.Clamped(interval(low, high, ir.Local(dist.type, "")), dist, low, high)
    raise Mistake(e07_draws.floats_not_clamped(span))


def _clamped_int(low: int, high: int, span: Span, dist: ir.Dist) -> ir.Dist:
    match dist:
        case ir.Certain(_, value):
            e = operators.clamp(value, low, high)
            return ir.Certain(e.type, e)
        case ir.Poisson(Int(least, most)) | ir.Binomial(Int(least, most)) | ir.UniformInt(Int(least, most)):
            t = Int(min(max(least, low), high), min(max(most, low), high))
            if isinstance(dist, ir.Poisson):
                _refuse_many(t.high, span)
            return replace(dist, type=t)
        case ir.Uniform(Int(least, most)):
            t = Int(min(max(least, low), high), min(max(most, low), high))
            return ir.UniformInt(t, operators.integer(least), operators.integer(most))
        case ir.Table(_, entries, rest, complements):
            forced = tuple((operators.clamp(v, low, high), p) for v, p in entries)
            last = None if rest is None else operators.clamp(rest, low, high)
            return ir.Table(Int(low, high), forced, last, complements)
        case ir.UniformSet(_, binders, condition, value, otherwise):
            other = None if otherwise is None else changed(otherwise, partial(_clamped_int, low, high, span))
            result = ir.UniformSet(
                Int(low, high), binders, condition, operators.clamp(value, low, high), None
            )
            return (
                result if other is None else replace(result, otherwise=fitted(other, result.type, span, ""))
            )
    raise Mistake(e07_draws.ints_not_clamped(span))


def binned(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``binned(D, low, high)``: the number of the bin into which D falls, over the type asked for."""
    if target is None or target == INT:
        raise Mistake(e07_draws.binned_without_type(node.span))
    if not isinstance(target, Int):
        raise Mistake(e03_types.draw_of_bins(what, target, node.span))
    drawn = node.arguments[0]
    dist = scope.draw(drawn, None, what)
    low, high = _float_ends(node, dist, scope)
    return changed(dist, partial(_binned, target, low, high, drawn.span))


def _binned(target: Int, low: ir.Expr, high: ir.Expr, span: Span, dist: ir.Dist) -> ir.Dist:
    if isinstance(dist, ir.Continuous) and not isinstance(dist, ir.Clamped):
        return ir.Binned(target, dist, low, high)
    if isinstance(dist, ir.Certain):
        raise Mistake(e07_draws.value_not_binned(span))
    raise Mistake(e07_draws.not_binned(span))
