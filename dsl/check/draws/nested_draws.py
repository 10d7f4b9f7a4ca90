# SPDX-License-Identifier: Apache-2.0
"""Draws within draws: ``let x ~ d in e``, and draws where a value may stand.

A draw that stands for a value gets a name of its own: ``go(uniform(Dir))`` is
``let d ~ uniform(Dir) in go(d)``. A table with draws for entries draws the entry's number first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.draws.fit_distribution import joined
from hypgen.dsl.check.draws.number_draws import refuse_unlimited
from hypgen.dsl.check.scope.draw_syntax import is_draw, is_normal
from hypgen.dsl.check.scope.let_bindings import let_dist, mentions
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.type_expressions import scalar_type
from hypgen.dsl.check.terms.references import owner_of
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.draw_words import MOST_WORDS, words_of
from hypgen.dsl.messages import e07_draws
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Float, Int, Record, Type, is_finite, size_of

_MOST_VALUES = 4096  # of a draw within a draw: a density goes through all of them
# Expressions, besides calls, whose parts are evaluated whenever they are.
STRICT = (ast.Binary, ast.Unary, ast.Member, ast.Index, ast.Is, ast.With)
Rest = Callable[[ast.Name, Scope], ir.Dist]


def let_in(node: ast.LetIn, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return ``let x ~ d in e``."""
    wanted = None if node.type is None else scalar_type(node.type, scope.program)
    law = _law(node.value, scope, wanted, f"'{node.name}'")
    inner = scope.bind(node.name, ir.Local(law.type, node.name), node.span)
    return _draw_in(node.name, law, inner.draw(node.body, target, what), node.span)


def named(node: ast.Expr, wanted: Type | None, scope: Scope, rest: Rest, op: str = "") -> ir.Dist:
    """Return ``rest`` of a name for what ``node`` draws; ``op`` is the operator that it is given to."""
    law = _law(node, scope, wanted, "this draw", op)
    name = scope.fresh("drawn")
    body = rest(ast.Name(node.span, name), scope.hide(name, ir.Local(law.type, name)))
    return _draw_in(name, law, body, node.span)


def lifted(node: ast.Expr, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return a value of which a part is a draw: the part is drawn first, and has a name in the value."""
    parts = _parts(node)
    number = next(n for n, part in enumerate(parts) if is_draw(part, scope))

    def rest(name: ast.Name, inner: Scope) -> ir.Dist:
        return inner.draw(_with_part(node, number, name), target, what)

    wanted = _wanted(node, len(parts), scope, target)[number]
    op = node.op if isinstance(node, ast.Binary) else ""
    return named(parts[number], wanted, scope, rest, op)


def mixture(
    node: ast.TableLiteral,
    weights: list[ir.Expr],
    complements: tuple[ir.Expr | None, ...],
    scope: Scope,
    target: Type | None,
    what: str,
) -> ir.Dist:
    """Return a table with draws for entries: the number of the entry is drawn first."""
    values = [n for n, _ in node.entries] + ([] if node.rest is None else [node.rest])
    name, t = scope.fresh("which"), Int(0, len(values) - 1)
    which = ir.Local(t, name)
    inner = scope.hide(name, which)
    found = gather([partial(inner.draw, n, target, what) for n in values])
    if target is None:
        found = joined([(d, n.span) for d, n in zip(found, values, strict=True)], what)
    body = found[-1]
    for number, dist in reversed(list(enumerate(found[:-1]))):
        common = operators.join(dist.type, body.type) or dist.type
        is_here = operators.compare("eq", which, operators.integer(number))
        body = ir.IfDist(common, is_here, dist, body)
    numbers = [ir.Const(t, number) for number in range(len(values))]
    rest = None if node.rest is None else numbers[-1]
    law = ir.Table(t, tuple(zip(numbers, weights, strict=False)), rest, complements)
    return _draw_in(name, law, body, node.span)


def _law(node: ast.Expr, scope: Scope, wanted: Type | None, what: str, op: str = "") -> ir.Dist:
    """Return what is drawn first: a law of few values, whose probabilities can be summed."""
    law = scope.draw(node, wanted, what)
    refuse_unlimited(law, node.span)
    if isinstance(law, ir.Certain):
        return law
    if isinstance(law.type, Float):
        raise Mistake(e07_draws.continuous_part(scope.kind, op if is_normal(node) else "", node.span))
    if not is_finite(law.type) or size_of(law.type) > _MOST_VALUES:
        raise Mistake(e07_draws.large_part(scope.kind, size_of(law.type), _MOST_VALUES, node.span))
    return law


def _draw_in(name: str, law: ir.Dist, body: ir.Dist, span: Span) -> ir.Dist:
    if isinstance(law, ir.Certain):
        return let_dist(name, law.value, body)
    if not mentions(body, name):
        return body
    result = ir.DrawIn(body.type, name, law, body)
    if words_of(result) > MOST_WORDS:
        raise Mistake(e07_draws.many_draws(MOST_WORDS, span))
    return result


def _parts(node: ast.Expr) -> tuple[ast.Expr, ...]:
    """Return the parts of an expression that are evaluated whenever it is."""
    match node:
        case ast.Binary(_, _, left, right):
            return (left, right)
        case ast.Unary(_, _, operand) | ast.Member(_, operand) | ast.Is(_, operand):
            return (operand,)
        case ast.With(_, operand, fields):
            return (operand, *(f.value for f in fields))
        case ast.Index(_, _, parts) | ast.Call(_, _, parts):
            return parts
    raise AssertionError(node)


def _with_part(node: ast.Expr, number: int, part: ast.Expr) -> ast.Expr:
    """Return the expression with another part."""
    match node:
        case ast.Binary():
            return replace(node, right=part) if number else replace(node, left=part)
        case ast.Unary() | ast.Member() | ast.Is():
            return replace(node, operand=part)
        case ast.With(_, _, fields):
            if number == 0:
                return replace(node, operand=part)
            changed = replace(fields[number - 1], value=part)
            return replace(node, fields=(*fields[: number - 1], changed, *fields[number:]))
        case ast.Index(_, _, parts):
            return replace(node, indices=(*parts[:number], part, *parts[number + 1 :]))
        case ast.Call(_, _, parts):
            return replace(node, arguments=(*parts[:number], part, *parts[number + 1 :]))
    raise AssertionError(node)


def _wanted(node: ast.Expr, count: int, scope: Scope, target: Type | None) -> list[Type | None]:
    """Return the types that the parts must have, as far as the expression says."""
    nothing: list[Type | None] = [None] * count
    if isinstance(node, ast.With) and isinstance(target, Record):
        return [target, *(target.field_type(f.name) for f in node.fields)]
    if not isinstance(node, ast.Call):
        return nothing
    symbols, found = scope.program.symbols, nothing
    function, record = symbols.functions.get(node.name), symbols.record(node.name)
    if function is not None:
        found = [f.type for f in scope.program.formals(function)]
    elif record is not None:
        t = scope.program.named_type(record)
        assert isinstance(t, Record)
        found = [part for _, part in t.fields]
    elif node.name in symbols.variants:
        variant = owner_of(node.name, node.span, scope, target).variant(node.name)
        found = [] if variant is None else [variant.argument]
    # Too many arguments, or too few: checking the call tells it.
    return found if len(found) == count else nothing
