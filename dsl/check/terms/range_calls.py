# SPDX-License-Identifier: Apache-2.0
"""``clamp``, ``wrap`` and ``checked``: values forced into a range, each for a reason of its own."""

from __future__ import annotations

from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.scope.fit_type import require_int32
from hypgen.dsl.check.scope.let_bindings import let_in
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_plain, require_same
from hypgen.dsl.check.terms.references import is_atomic
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e03_calls, e03_types, e06_ranges, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT, PROB, Float, Int, Type


def number(node: ast.Expr, scope: Scope, name: str) -> ir.Expr:
    """Return an argument of the function ``name``, which takes numbers."""
    e = scope.check(node)
    if not operators.is_numeric(e.type):
        raise Mistake(e03_types.argument_not_a_number(name, e.type, node.span))
    return e


def check(node: ast.Call, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return ``clamp wrap checked`` of a number, into given ends or into the range that is asked for."""
    name, given = node.name, len(node.arguments)
    if given not in (1, 3):
        raise Mistake(e03_calls.wrong_arguments_of_range_call(name, given, node.span))
    if given == 1:
        return _into_target(node, scope, expected)
    values = gather([partial(number, n, scope, name) for n in node.arguments])
    spans = [n.span for n in node.arguments]
    require_same(list(zip(values, spans, strict=True)), f"go together in '{name}'")
    if any(isinstance(v.type, Float) for v in values):
        values = [operators.to_float(v) for v in values]
    operand, low, high = values
    if isinstance(low, ir.Const) and isinstance(high, ir.Const):
        if low.value > high.value:
            raise Mistake(e06_ranges.swapped_ends(name, node.span))
        return _forced(node, operand, low, high, scope)
    if name == "clamp":
        return operators.arithmetic("min", operators.arithmetic("max", operand, low), high)
    raise Mistake(e08_parts.ends_not_constant(name, node.span))


def _into_target(node: ast.Call, scope: Scope, expected: Type | None) -> ir.Expr:
    name, span = node.name, node.arguments[0].span
    finite = isinstance(expected, Int) and expected != INT
    if not isinstance(expected, Int | Float) or not (finite or expected == PROB):
        raise Mistake(e03_types.no_ends(name, node.span))
    e = number(node.arguments[0], scope, name)
    if isinstance(expected, Float):
        require_plain(e, span, "a probability")
        return _forced(
            node, operators.to_float(e), operators.real(expected.low), operators.real(expected.high), scope
        )
    if isinstance(e.type, Float):
        raise Mistake(e03_types.float_into_int_range(name, span))
    return _forced(node, e, operators.integer(expected.low), operators.integer(expected.high), scope)


def _forced(node: ast.Call, e: ir.Expr, low: ir.Const, high: ir.Const, scope: Scope) -> ir.Expr:
    """Return ``e`` forced into constant ends of its own kind."""
    if node.name == "clamp":
        return operators.clamp(e, low.value, high.value)
    least, most = operators.ends(e.type)
    if low.value <= least and most <= high.value:
        return e
    if node.name == "checked":
        if most < low.value or high.value < least:
            raise Mistake(e06_ranges.never_in_range(least, most, low.value, high.value, node.span))
        return operators.clamp(e, low.value, high.value, ir.Checked)
    return _wrapped(e, low, high, node.span, scope)


def _wrapped(e: ir.Expr, low: ir.Const, high: ir.Const, span: Span, scope: Scope) -> ir.Expr:
    """Return ``e`` less a multiple of the range's length: of ``low .. high``, or up to a float ``high``."""
    if isinstance(e.type, Int):
        length = operators.integer(int(high.value) - int(low.value) + 1)
        offset = require_int32(operators.arithmetic("sub", e, low), span)
        return operators.arithmetic("add", operators.arithmetic("mod", offset, length), low)
    span_of = operators.arithmetic("sub", high, low)
    if isinstance(span_of, ir.Const) and not span_of.value > 0:
        raise Mistake(e06_ranges.empty_wrap(span))
    name = scope.fresh("wrapped")
    x = e if is_atomic(e) else ir.Local(e.type, name)
    turns = operators.arithmetic("div", operators.arithmetic("sub", x, low), span_of)
    whole = operators.to_float(operators.to_int("floor", turns))
    moved = operators.arithmetic("sub", x, operators.arithmetic("mul", span_of, whole))
    return let_in(name, e, operators.clamp(moved, low.value, high.value))  # rounding may pass an end
