# SPDX-License-Identifier: Apache-2.0
"""``sum any all count min max argmin argmax`` over the values of finite types."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from math import prod

from hypgen.dsl import ir
from hypgen.dsl.check.scope.draw_syntax import misplaced, refuse_draw_for_each
from hypgen.dsl.check.scope.fit_type import check_as, fit
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.type_expressions import require_finite
from hypgen.dsl.check.scope.unit_checks import require_same
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e02_names, e03_calls, e03_types, e03_units, e06_ranges
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, FLOAT, INT32_MAX, Int, Type, intervals, size_of
from hypgen.dsl.types.builtin_names import QUANTIFIERS

_EXTREMES = ("min", "max", "argmin", "argmax")
_MAX_UNFOLDED = 1 << 16


def check(node: ast.Quantified, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return the value of a quantifier."""
    _check_form(node, scope)
    binders = bind_types(node.binders, scope)
    if scope.constant:
        return _unfold(node, binders, scope, expected)
    inner = bind_all(node.binders, binders, scope)
    refuse_draw_for_each(node.where, inner)
    refuse_draw_for_each(node.body, inner)
    condition = (
        None if node.where is None else check_as(node.where, inner, BOOL, "the condition after 'where'")
    )
    inner = inner if condition is None else inner.given(condition)
    condition = None if condition is None or operators.is_true(condition) else condition
    if node.kind in _EXTREMES:
        return _extreme(node, binders, condition, inner, scope)
    if node.kind in ("any", "all"):
        body: ir.Expr = operators.TRUE
        if node.body is not None:
            body = check_as(node.body, inner, BOOL, f"what '{node.kind}' tests")
        empty = condition is not None and operators.is_false(condition)
        neutral = operators.boolean(node.kind == "all")
        if empty or body == neutral:
            return neutral
        if condition is None and isinstance(body, ir.Const):
            return body
        return ir.Quantified(BOOL, node.kind, binders, condition, body, None)
    count = prod(size_of(b.type) for b in binders)
    if condition is not None and operators.is_false(condition):
        return operators.integer(0)
    if node.kind == "count":
        low = 0 if condition is not None else count
        return ir.Quantified(Int(low, count), "count", binders, condition, None, None)
    assert node.body is not None
    summand = inner.check(node.body)
    _require_summand(summand, node.body)
    total = intervals.repeated(operators.ends(summand.type), count, condition is None)
    return ir.Quantified(operators.numeric(summand.type, total), "sum", binders, condition, summand, None)


def _check_form(node: ast.Quantified, scope: Scope) -> None:
    if node.kind in ("uniform", "weighted"):
        raise misplaced(f"{node.kind}(..)", node, scope)
    if node.kind not in QUANTIFIERS:
        if node.kind == "distance":
            raise Mistake(e03_units.distance_as_value(node.span))
        raise Mistake(e02_names.unknown_quantifier(node.kind, QUANTIFIERS, node.span))
    if node.kind == "count" and node.body is not None:
        raise Mistake(e03_calls.count_with_body(node.body.span))
    if node.kind != "count" and node.body is None and not (node.kind == "any" and node.where is not None):
        raise Mistake(e03_calls.without_body(node.kind, node.span))
    if node.otherwise is not None and node.kind not in _EXTREMES:
        raise Mistake(e03_calls.needless_else(node.kind, node.otherwise.span))
    if node.kind in ("argmin", "argmax") and len(node.binders) != 1:
        raise Mistake(e03_calls.several_binders(node.kind, node.span))


def _require_summand(e: ir.Expr, node: ast.Expr) -> None:
    if not operators.is_numeric(e.type):
        raise Mistake(e03_types.summand_not_a_number(e.type, node.span))


def bind_types(nodes: tuple[ast.Binder, ...], scope: Scope) -> tuple[ir.Binder, ...]:
    """Return binders with their types, which must be finite."""
    return tuple(gather([partial(_binder, n, scope) for n in nodes]))


def _binder(node: ast.Binder, scope: Scope) -> ir.Binder:
    found = scope.program.type_of(node.type)
    require_finite(found, node.type.span, f"'{node.name}'")
    return ir.Binder(node.name, found)


def bind_all(nodes: tuple[ast.Binder, ...], binders: tuple[ir.Binder, ...], scope: Scope) -> Scope:
    """Return ``scope`` with the binders as locals."""
    for node, binder in zip(nodes, binders, strict=True):
        scope = scope.bind(binder.name, ir.Local(binder.type, binder.name), node.span)
    return scope


def values_of(binders: tuple[ir.Binder, ...]) -> Iterator[dict[str, ir.Const]]:
    """Yield every combination of the binders' values, in order."""
    ranges = [range(size_of(b.type)) for b in binders]
    for indices in product(*ranges):
        yield {b.name: operators.from_index(b.type, i) for b, i in zip(binders, indices, strict=True)}


def _extreme(
    node: ast.Quantified,
    binders: tuple[ir.Binder, ...],
    condition: ir.Expr | None,
    inner: Scope,
    scope: Scope,
) -> ir.Expr:
    assert node.body is not None
    if condition is not None and operators.is_false(condition) and node.otherwise is None:
        raise Mistake(e06_ranges.extreme_of_nothing(node.kind, node.span))
    body = inner.check(node.body)
    if not operators.is_numeric(body.type):
        raise Mistake(e03_types.extreme_of_other(node.kind, body.type, node.body.span))
    picks = node.kind in ("argmin", "argmax")
    result: Type = binders[0].type if picks else body.type
    otherwise = None
    if node.otherwise is not None:
        if picks:
            otherwise = check_as(node.otherwise, scope, result, "the value after 'else'")
        else:
            otherwise = scope.check(node.otherwise)
            require_same([(body, node.body.span), (otherwise, node.otherwise.span)], "mix in one value")
            if operators.is_numeric(otherwise.type):
                body, otherwise = operators.promote(body, otherwise)
            result = operators.join(body.type, otherwise.type) or FLOAT
            otherwise = fit(otherwise, result, node.otherwise.span, "the value after 'else'")
    return ir.Quantified(result, node.kind, binders, condition, body, otherwise)


def _unfold(
    node: ast.Quantified, binders: tuple[ir.Binder, ...], scope: Scope, expected: Type | None
) -> ir.Expr:
    """Return the value of a quantifier in a constant expression, by going through all values."""
    if prod(size_of(b.type) for b in binders) > min(_MAX_UNFOLDED, INT32_MAX):
        raise Mistake(e06_ranges.many_values_to_unfold(node.span))
    bind_all(node.binders, binders, scope)  # for its checks
    result: ir.Expr | None = {
        "sum": operators.integer(0),
        "count": operators.integer(0),
        "any": operators.FALSE,
        "all": operators.TRUE,
    }.get(node.kind)
    best: ir.Expr | None = None
    for values in values_of(binders):
        inner = replace(scope, locals={**scope.locals, **values})
        where = operators.TRUE if node.where is None else check_as(node.where, inner, BOOL, "the condition")
        if not operators.is_true(where):
            continue
        if node.kind == "count":
            assert result is not None
            result = operators.arithmetic("add", result, operators.integer(1))
            continue
        body = operators.TRUE if node.body is None else inner.check(node.body)
        if node.kind == "sum":
            assert result is not None
            _require_summand(body, node.body or node)
            result = operators.arithmetic("add", result, body)
        elif node.kind in ("any", "all"):
            assert result is not None
            body = fit(body, BOOL, (node.body or node).span, f"what '{node.kind}' tests")
            result = operators.either(result, body) if node.kind == "any" else operators.both(result, body)
        elif best is None or operators.is_true(
            operators.compare("lt" if node.kind.endswith("min") else "gt", *operators.promote(body, best))
        ):
            best = body
            result = values[binders[0].name] if node.kind.startswith("arg") else body
    if result is None and node.otherwise is not None:
        result = scope.check(node.otherwise, expected)
    if result is None:
        raise Mistake(e06_ranges.extreme_of_nothing(node.kind, node.span))
    return result
