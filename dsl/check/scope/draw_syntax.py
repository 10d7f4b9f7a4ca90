# SPDX-License-Identifier: Apache-2.0
"""Telling draws from values."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl import ir
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.messages import e01_syntax, e07_draws
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Record, Type, builtin_names


def is_draw(node: ast.Expr, scope: Scope) -> bool:
    """Return whether ``node`` is a distribution: a draw, or a choice with one among its results."""
    match node:
        case ast.TableLiteral():
            return True
        case ast.Call(_, "clamp", (first, *_)):
            return is_draw(first, scope)
        case ast.Call(_, name) if name in builtin_names.DRAWS or named_draw(name, scope) is not None:
            return True
        case ast.Call(_, name, (argument,)):
            return name in scope.program.symbols.variants and is_draw(argument, scope)
        case ast.Prime(_, ast.Call(_, name)):
            return named_draw(name, scope) is not None
        case ast.Quantified(_, kind):
            return kind in builtin_names.DRAWS
        case ast.If(_, _, then, otherwise):
            return is_draw(then, scope) or is_draw(otherwise, scope)
        case ast.Match(_, _, arms):
            return any(is_draw(a.body, scope) for a in arms)
        case ast.LetIn(_, _, _, body) | ast.Comprehension(_, _, body):
            return is_draw(body, scope)
    return False


def named_draw(name: str, scope: Scope) -> ast.Function | None:
    """Return the function of that name if it names a distribution: ``fn name(..): T ~ D``."""
    item = scope.program.symbols.globals.get(name)
    return item if isinstance(item, ast.Function) and item.rhs.draw else None


def refuse_operand(op: str, operands: Sequence[ast.Expr], scope: Scope) -> None:
    """Raise if an operand of ``op`` is a draw."""
    for operand in operands:
        if is_draw(operand, scope):
            is_normal = isinstance(operand, ast.Call) and operand.name == "normal"
            raise Mistake(e07_draws.draw_as_operand(op, is_normal, operand.span))


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
    if is_draw(node.value, scope):
        raise Mistake(e07_draws.misplaced_draw("the value of this 'let'", node.value.span))
    value = scope.check(node.value)
    local = value if isinstance(value, ir.Const) else ir.Local(value.type, node.name)
    return value, scope.bind(node.name, local, node.span)
