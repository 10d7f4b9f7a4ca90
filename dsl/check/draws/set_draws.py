# SPDX-License-Identifier: Apache-2.0
"""Draws from the values of types: ``uniform(T)``, ``uniform(i in T: ..)`` and ``weighted(i in T: ..)``."""

from __future__ import annotations

from hypgen.dsl import ir
from hypgen.dsl.check.draws.fit_distribution import fitted, require_range, uniform_over
from hypgen.dsl.check.scope.draw_syntax import is_draw, refuse_draw_for_each
from hypgen.dsl.check.scope.fit_type import check_as, fit
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.type_expressions import require_finite
from hypgen.dsl.check.terms.quantifiers import bind_all, bind_types
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.nodes import placed
from hypgen.dsl.messages import e03_types, e06_ranges, e07_draws
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, FLOAT, Float, Int, Type


def uniform_type(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``uniform(T)``."""
    argument = node.arguments[0]
    if not isinstance(argument, ast.Name):
        raise Mistake(e07_draws.uniform_of_other(argument.span))
    found = scope.program.type_of(ast.TypeName(argument.span, argument.name))
    require_finite(found, argument.span, "a uniform draw")
    if target is None:
        return ir.Uniform(found)
    if isinstance(target, Int) and isinstance(found, Int):
        require_range(found, target, node.span, what)
    elif target != found:
        raise Mistake(e03_types.mismatch(what, target, found, node.span))
    return uniform_over(found, target)


def _condition(node: ast.Quantified, scope: Scope) -> ir.Expr | None:
    if node.where is None:
        return None
    refuse_draw_for_each(node.where, scope)
    condition = check_as(node.where, scope, BOOL, "the condition after 'where'")
    if operators.is_false(condition) and node.otherwise is None:
        raise Mistake(e06_ranges.empty_set(node.span))
    return condition


def uniform_set(node: ast.Quantified, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``uniform(i in T where c: value else d)``."""
    binders = bind_types(node.binders, scope)
    inner = bind_all(node.binders, binders, scope)
    condition = _condition(node, inner)
    inner = inner if condition is None else inner.given(condition)
    body = node.body
    if body is None:
        if len(binders) != 1:
            raise Mistake(e07_draws.uniform_without_value(node.span))
        body = ast.Name(node.binders[0].span, binders[0].name)
    if is_draw(body, inner):
        raise Mistake(e07_draws.draw_of_drawn(node.binders[0].name, body.span))
    value = inner.check(body, target)
    if target is not None:
        value = fit(value, target, body.span, what)
    t = target or (binders[0].type if node.body is None else value.type)
    if not isinstance(t, Float):
        require_finite(t, node.span, "a uniform draw")
    otherwise = None if node.otherwise is None else scope.draw(node.otherwise, t, what)
    return ir.UniformSet(t, binders, condition, value, otherwise)


def weighted(node: ast.Quantified, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``weighted(i in T where c: weight else d)``."""
    binders = bind_types(node.binders, scope)
    if len(binders) != 1 or node.body is None:
        raise Mistake(e07_draws.weighted_without_form(node.span))
    inner = bind_all(node.binders, binders, scope)
    condition = _condition(node, inner)
    inner = inner if condition is None else inner.given(condition)
    refuse_draw_for_each(node.body, inner)
    weight = placed(check_as(node.body, inner, FLOAT, "a weight"), node.body.span)
    low, high = operators.ends(weight.type)
    if high < 0:
        raise Mistake(e07_draws.negative_weights(node.body.span))
    if high == 0 and node.otherwise is None:
        raise Mistake(e06_ranges.only_zero_weights(node.body.span))
    own = binders[0].type
    if node.otherwise is None:
        return fitted(ir.Weighted(own, (binders[0],), condition, weight, None), target, node.span, what)
    fitted(ir.Uniform(own), target, node.span, what)  # for its checks
    otherwise = scope.draw(node.otherwise, target or own, what)
    return ir.Weighted(target or own, (binders[0],), condition, weight, otherwise)
