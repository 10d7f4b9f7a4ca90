# SPDX-License-Identifier: Apache-2.0
"""Draws of numbers by a law: ``normal uniform exponential poisson binomial``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.draws.fit_distribution import changed, fitted, refused, uniform_over
from hypgen.dsl.check.scope.fit_type import check_as, fit
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_same
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.nodes import placed
from hypgen.dsl.messages import e03_types, e06_ranges, e07_draws
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import FLOAT, INT, INT32_MAX, PROB, Bool, Float, Int, Type, units

MOST_COUNT = 1000
_MOST_MEAN = 690.0


def check(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return what a call of one of the laws draws, over ``target`` (None: over the law's own type)."""
    match node.name:
        case "normal":
            return continuous(_normal(node, scope), target, node.span, what)
        case "exponential":
            return continuous(_exponential(node, scope), target, node.span, what)
        case "poisson":
            return _poisson(node, scope, target, what)
        case "binomial":
            return _binomial(node, scope, target, what)
        case "uniform":
            return _uniform(node, scope, target, what)
    raise AssertionError(f"no check of {node.name}")


def continuous(dist: ir.Dist, target: Type | None, span: Span, what: str) -> ir.Dist:
    """Return a continuous draw over ``target``, which must be a float."""
    if target is None:
        return dist
    if isinstance(target, Float):
        t = fit(ir.Local(dist.type, ""), target, span, what).type
        return changed(dist, lambda d: replace(d, type=t) if isinstance(d, ir.Continuous) else d)
    if isinstance(target, Int):
        raise Mistake(e07_draws.continuum_for_int(what, target, span))
    raise refused(target, FLOAT, span, what)


def numbers(node: ast.Call, names: Sequence[str], scope: Scope) -> list[ir.Expr]:
    """Return the arguments of ``node`` from the last on, one for each of ``names``: numbers of one unit."""
    nodes = node.arguments[-len(names) :]
    found = gather([partial(_number, n, scope, name) for n, name in zip(nodes, names, strict=True)])
    require_same(list(zip(found, [n.span for n in nodes], strict=True)), f"go together in '{node.name}'")
    return found


def _number(node: ast.Expr, scope: Scope, name: str) -> ir.Expr:
    e = scope.check(node)
    if not operators.is_numeric(e.type):
        raise Mistake(e03_types.parameter_not_a_number(name, e.type, node.span))
    return e


def interval(low: float, high: float, *parts: ir.Expr) -> Float:
    """Return the type of floats from ``low`` to ``high``, of the unit that the parts have."""
    unit = None
    for part in parts:
        unit = units.merged(unit, operators.unit_of(part))
    return Float(low, high, unit=unit)


def _normal(node: ast.Call, scope: Scope) -> ir.Dist:
    mean, deviation = numbers(node, ("the mean", "the standard deviation"), scope)
    _require_above_zero(deviation, node.arguments[1].span, "the standard deviation")
    t = interval(-math.inf, math.inf, mean, deviation)
    placed_deviation = placed(operators.to_float(deviation), node.arguments[1].span)
    return ir.Normal(t, operators.to_float(mean), placed_deviation)


def _exponential(node: ast.Call, scope: Scope) -> ir.Dist:
    (mean,) = numbers(node, ("the mean",), scope)
    _require_above_zero(mean, node.arguments[0].span, "the mean")
    own = interval(0.0, math.inf, mean)
    return ir.Exponential(own, placed(operators.to_float(mean), node.arguments[0].span))


def _require_above_zero(e: ir.Expr, span: Span, what: str) -> None:
    _, high = operators.ends(e.type)
    if high <= 0:
        raise Mistake(e07_draws.not_above_zero(what, high, span))


def _uniform(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    low, high = numbers(node, ("the lower end", "the upper end"), scope)
    if operators.ends(low.type)[0] > operators.ends(high.type)[1]:
        raise Mistake(e06_ranges.swapped_ends("uniform", node.span))
    if isinstance(target, Float) or isinstance(low.type, Float) or isinstance(high.type, Float):
        low, high = operators.to_float(low), operators.to_float(high)
        (least, _), (lower, most) = operators.ends(low.type), operators.ends(high.type)
        t = interval(min(least, lower), most, low, high)
        return continuous(ir.UniformFloat(t, low, high), target, node.span, what)
    assert isinstance(low.type, Int) and isinstance(high.type, Int)
    if isinstance(low, ir.Const) and isinstance(high, ir.Const):
        own = Int(int(low.value), int(high.value))
        checked = fitted(ir.Uniform(own), target, node.span, what)
        return checked if target is None else uniform_over(own, target)
    own = Int(low.type.low, max(low.type.high, high.type.high))
    return fitted(ir.UniformInt(own, low, high), target, node.span, what)


def _poisson(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    mean = placed(check_as(node.arguments[0], scope, FLOAT, "the mean"), node.arguments[0].span)
    low, high = operators.ends(mean.type)
    if high < 0 or low > _MOST_MEAN:
        mean_value = high if high < 0 else low
        raise Mistake(e07_draws.poisson_mean(mean_value, _MOST_MEAN, node.arguments[0].span))
    dist = ir.Poisson(Int(0, INT32_MAX), 0, None, mean)
    if isinstance(target, Int):
        refuse_unlimited(dist, node.span)
    return fitted(dist, target, node.span, what)


def refuse_unlimited(dist: ir.Dist, span: Span) -> None:
    """Raise if ``dist`` may draw counts without end."""
    match dist:
        case ir.IfDist(_, _, then, otherwise):
            refuse_unlimited(then, span)
            refuse_unlimited(otherwise, span)
        case ir.DrawIn(law=law, body=body):
            refuse_unlimited(law, span)
            refuse_unlimited(body, span)
        case ir.LetDist(body=inner) | ir.Widened(dist=inner) | ir.InVariant(dist=inner):
            refuse_unlimited(inner, span)
        case ir.Poisson(Int(_, high)) if high == INT32_MAX:
            raise Mistake(e07_draws.unlimited_poisson(span))


def _binomial(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    trials, p = gather(
        [
            partial(check_as, node.arguments[0], scope, INT, "the number of trials"),
            partial(check_as, node.arguments[1], scope, PROB, "the probability"),
        ]
    )
    assert isinstance(trials.type, Int)
    if trials.type.low < 0 or trials.type.high > MOST_COUNT:
        raise Mistake(e07_draws.binomial_trials(trials.type, MOST_COUNT, node.arguments[0].span))
    dist = ir.Binomial(Int(0, trials.type.high), 0, None, trials, placed(p, node.arguments[1].span))
    if isinstance(target, Bool):
        raise refused(target, dist.type, node.span, what)
    return fitted(dist, target, node.span, what)
