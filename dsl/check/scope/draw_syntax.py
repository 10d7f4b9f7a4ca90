# SPDX-License-Identifier: Apache-2.0
"""Telling draws from values."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl import ir
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.type_expressions import scalar_type
from hypgen.dsl.messages import e01_syntax, e07_draws
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Record, Type, builtin_names


def is_draw(node: ast.Expr, scope: Scope) -> bool:
    """Return whether ``node`` is a distribution: a draw, a choice among some, or a value with one in it."""
    match node:
        case ast.TableLiteral():
            return True
        case ast.Call(_, name) if name in builtin_names.DRAWS or named_draw(name, scope) is not None:
            return True
        case ast.Call(_, name, arguments):
            return name not in builtin_names.HISTORY | builtin_names.CUMULATIVE and _is_any_draw(
                arguments, scope
            )
        case ast.Prime(_, ast.Call(_, name, arguments)):
            return named_draw(name, scope) is not None or (
                name not in builtin_names.DRAWS and _is_any_draw(arguments, scope)
            )
        case ast.Quantified(_, kind):
            return kind in builtin_names.DRAWS
        case ast.If(_, condition, then, otherwise):
            return _is_any_draw((condition, then, otherwise), scope)
        case ast.Match(_, scrutinee, arms):
            return _is_any_draw((scrutinee, *(a.body for a in arms)), scope)
        case ast.LetIn(_, _, _, body, draw):
            return draw or is_draw(body, scope)
        case ast.Comprehension(_, _, body):
            return is_draw(body, scope)
        case ast.Unary(_, _, operand) | ast.Member(_, operand) | ast.Is(_, operand):
            return is_draw(operand, scope)
        case ast.With(_, operand, fields):
            return _is_any_draw((operand, *(f.value for f in fields)), scope)
        case ast.Binary(_, _, left, right):
            return _is_any_draw((left, right), scope)
        case ast.Index(_, _, indices):
            return _is_any_draw(indices, scope)
    return False


def _is_any_draw(nodes: Sequence[ast.Expr], scope: Scope) -> bool:
    return any(is_draw(node, scope) for node in nodes)


def is_normal(node: ast.Expr) -> bool:
    """Return whether ``node`` is a normal draw, which can be shifted and scaled inside."""
    return isinstance(node, ast.Call) and node.name == "normal"


def named_draw(name: str, scope: Scope) -> ast.Function | None:
    """Return the function of that name if it names a distribution: ``fn name(..): T ~ D``."""
    item = scope.program.symbols.functions.get(name)
    return item if item is not None and item.rhs.draw else None


def misplaced(what: str, node: ast.Expr, scope: Scope) -> Mistake:
    """Return the mistake of a draw where a value is needed."""
    owner = "constant" if scope.constant else scope.kind
    return Mistake(e07_draws.misplaced_draw(what, owner, node.span))


def refuse_draw_for_each(node: ast.Expr | None, scope: Scope) -> None:
    """Raise if what is evaluated for each value of a type is a draw."""
    if node is not None and is_draw(node, scope):
        raise Mistake(e07_draws.draw_for_each(node.span))


def fields_of_record(node: ast.Expr, name: str, fields: Sequence[str]) -> Mistake | None:
    """Return the mistake of writing a record as a struct of other languages, `{x: 1, y: 2}`, if it is one."""
    if not isinstance(node, ast.TableLiteral) or node.rest is not None:
        return None
    given = [value.name for value, _ in node.entries if isinstance(value, ast.Name)]
    if sorted(given) != sorted(fields) or len(given) < len(node.entries):
        return None
    return Mistake(e01_syntax.record_in_braces(name, fields, node.span))


def refuse_fields(node: ast.Expr, target: Type | None) -> None:
    """Raise if a value of the record ``target`` is written as a struct of other languages."""
    if isinstance(target, Record):
        found = fields_of_record(node, target.name, [name for name, _ in target.fields])
        if found is not None:
            raise found


def bind_value(node: ast.LetIn, scope: Scope) -> tuple[ir.Expr, Scope]:
    """Return the value of ``let .. in`` and the scope of its body."""
    if node.draw:
        raise misplaced(f"what this 'let' calls '{node.name}'", node.value, scope)
    if is_draw(node.value, scope):
        raise Mistake(e07_draws.draw_behind_equals(node.value.span))
    if node.type is None:
        value = scope.check(node.value)
    else:
        value = check_as(node.value, scope, scalar_type(node.type, scope.program), f"'{node.name}'")
    local = value if isinstance(value, ir.Const) else ir.Local(value.type, node.name)
    return value, scope.bind(node.name, local, node.span)
