# SPDX-License-Identifier: Apache-2.0
"""``at(array, i, .., default)``: an entry where the index is in range, otherwise the default."""

from __future__ import annotations

from collections.abc import Iterator

from hypgen.dsl import ir
from hypgen.dsl.check.scope.fit_type import check_as, unify
from hypgen.dsl.check.scope.let_bindings import let_in
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.terms.range_calls import number
from hypgen.dsl.check.terms.references import find, is_atomic
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e03_calls, e03_types
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Float, Int, Record, Type


def at(node: ast.Call, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return the read with its guard."""
    if len(node.arguments) < 3:
        raise Mistake(e03_calls.few_arguments_of_at(node.span))
    array, *nodes, last = node.arguments
    reference = find(array.operand, scope.prime()) if isinstance(array, ast.Prime) else find(array, scope)
    if reference is None or not reference.indices:
        raise Mistake(e03_calls.at_of_other(array.span))
    types = [t for index in reference.indices for t in _fields(index)]
    if len(nodes) == len(reference.indices):
        types = list(reference.indices)
    elif len(nodes) != len(types):
        raise Mistake(
            e03_calls.wrong_indexes_of_at(reference.label, reference.indices, len(nodes), node.span)
        )
    inside: ir.Expr = operators.TRUE
    indices: list[ir.Expr] = []
    named: list[tuple[str, ir.Expr]] = []
    for index_node, t in zip(nodes, types, strict=True):
        if not isinstance(t, Int):
            indices.append(check_as(index_node, scope, t, f"the index of '{reference.label}'", is_index=True))
            continue
        e = number(index_node, scope, "at")
        if isinstance(e.type, Float):
            raise Mistake(e03_types.float_as_index(index_node.span))
        if not is_atomic(e):
            name = scope.fresh("index")
            named.append((name, e))
            e = ir.Local(e.type, name)
            scope = scope.hide(name, e)
        for op, end in (("ge", t.low), ("le", t.high)):
            inside = operators.both(inside, operators.compare(op, e, operators.integer(end)))
        indices.append(_within(e, t))
    if len(types) > len(reference.indices):
        parts = iter(indices)
        indices = [_joined(t, parts) for t in reference.indices]
    read = scope.narrow(reference.entry(tuple(indices)))
    if operators.is_numeric(read.type):
        default = number(last, scope, "at")
        read, default = unify([(read, array.span), (default, last.span)], expected)
    else:
        default = check_as(last, scope, read.type, f"what stands in for '{reference.label}'")
    result = operators.choose(inside, read, default)
    for name, value in reversed(named):
        result = let_in(name, value, result)
    return result


def _within(e: ir.Expr, t: Int) -> ir.Expr:
    """Return an index as what it is where it lies in its type; anything in range where it never does."""
    assert isinstance(e.type, Int)
    low, high = max(e.type.low, t.low), min(e.type.high, t.high)
    if low > high or isinstance(e, ir.Const):
        return operators.integer(min(max(e.type.low, t.low), t.high))
    return operators.retyped(e, Int(low, high))


def _fields(t: Type) -> list[Type]:
    """Return the types of an index's numbers: a record counts as its fields."""
    return [inner for _, part in t.fields for inner in _fields(part)] if isinstance(t, Record) else [t]


def _joined(t: Type, parts: Iterator[ir.Expr]) -> ir.Expr:
    """Return an index made of the next of its numbers."""
    if not isinstance(t, Record):
        return next(parts)
    return operators.make_record(t, tuple(_joined(part, parts) for _, part in t.fields))
