# SPDX-License-Identifier: Apache-2.0
"""Values of an array's entries: a comprehension, a list, a grid, or an array's name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.constants import constants
from hypgen.dsl.check.constants.constants import require_indices
from hypgen.dsl.check.draws.distributions import right_side
from hypgen.dsl.check.scope import grid_literals
from hypgen.dsl.check.scope.draw_syntax import is_draw
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.terms.quantifiers import bind_all, bind_types
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e07_draws, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Type, length_of, size_of

_NAMES = "ijklmnpqrstuvw"
_MAX_VARYING = 32  # entries of a list that are no constants: each is a branch


def array_of(
    rhs: ast.Rhs, indices: tuple[Type, ...], scope: Scope, target: Type, name: str
) -> tuple[tuple[ir.Binder, ...], ir.Dist]:
    """Return what ``rhs`` says of an array's entry, and the binders of its indexes; a scalar has none."""
    if not indices:
        return (), right_side(rhs, scope, target, f"'{name}'")
    node = rhs.expr
    if isinstance(node, ast.ArrayLiteral) or grid_literals.is_grid(node):
        return _literal(node, indices, scope, target, name)
    if isinstance(node, ast.Name) and isinstance(
        scope.program.symbols.values.get(node.name), ast.Const | ast.Param
    ):
        return _named(node, indices, scope, target, name)
    if not isinstance(node, ast.Comprehension):
        raise Mistake(e07_draws.draw_for_array(name, indices, rhs.span))
    binders = bind_types(node.binders, scope)
    require_indices(node, binders, indices[: len(binders)] if len(binders) < len(indices) else indices, name)
    inner = bind_all(node.binders, binders, scope)
    rest, dist = array_of(
        ast.Rhs(node.body.span, rhs.draw, node.body), indices[len(binders) :], inner, target, name
    )
    return binders + rest, dist


def _binders(indices: tuple[Type, ...], scope: Scope) -> tuple[ir.Binder, ...]:
    """Return binders that the author has not named."""
    found: list[ir.Binder] = []
    for letter, t in zip(_NAMES, indices, strict=False):
        found.append(ir.Binder(scope.fresh(letter), t))
        scope = scope.hide(found[-1].name, ir.Local(t, found[-1].name))
    return tuple(found)


def _named(
    node: ast.Name, indices: tuple[Type, ...], scope: Scope, target: Type, name: str
) -> tuple[tuple[ir.Binder, ...], ir.Dist]:
    """Return the entries of a const or param that is an array, index by index."""
    binders = _binders(indices, scope)
    inner = replace(scope, locals={**scope.locals, **{b.name: ir.Local(b.type, b.name) for b in binders}})
    read = ast.Index(node.span, node, tuple(ast.Name(node.span, b.name) for b in binders))
    return binders, ir.Certain(target, check_as(read, inner, target, f"'{name}'"))


def _literal(
    node: ast.Expr, indices: tuple[Type, ...], scope: Scope, target: Type, name: str
) -> tuple[tuple[ir.Binder, ...], ir.Dist]:
    """Return the entries of a list: a table where all are constants, else a choice by the index."""
    leaves = list(_leaves(node, len(indices)))
    gather([partial(_refuse_draw, leaf, scope, name) for leaf in leaves])
    binders = _binders(indices, scope)
    places = tuple(ir.Local(b.type, b.name) for b in binders)
    constant = replace(scope, owner=None, evaluate=True, constant=True)
    try:
        values = constants.entries_of(node, constant, target, indices, name)
    except Mistake as error:
        varies = bool(error.diagnostics) and all(d.code == e08_parts.NOT_CONSTANT for d in error.diagnostics)
        if not varies or len(leaves) != length_of(indices) or len(leaves) > _MAX_VARYING:
            raise
        found = gather([partial(check_as, leaf, scope, target, f"'{name}'") for leaf in leaves])
        return binders, ir.Certain(target, _chosen(found, places))
    key = str(scope.owner or name).replace(" ", ":")
    table = constants.array(key, target, indices, values, node.span, node)
    scope.program.literals.append(table)
    return binders, ir.Certain(target, ir.TableRead(target, table.name, places))


def _leaves(node: ast.Expr, depth: int) -> Iterator[ast.Expr]:
    """Yield the entries of nested lists, and what stands in the place of a list."""
    if depth == 0 or not isinstance(node, ast.ArrayLiteral):
        yield node
    else:
        for item in node.items:
            yield from _leaves(item, depth - 1)


def _refuse_draw(node: ast.Expr, scope: Scope, name: str) -> None:
    if is_draw(node, scope):
        raise Mistake(e07_draws.draw_in_list(name, node.span))


def _chosen(entries: list[ir.Expr], places: tuple[ir.Local, ...]) -> ir.Expr:
    """Return the entry at ``places``."""
    if not places:
        return entries[0]
    t, rest = places[0].type, places[1:]
    stride = len(entries) // size_of(t)
    parts = [_chosen(entries[i : i + stride], rest) for i in range(0, len(entries), stride)]
    result = parts.pop()
    for number, part in reversed(list(enumerate(parts))):
        here = operators.compare("eq", places[0], operators.from_index(t, number))
        result = operators.choose(here, part, result)
    return result
