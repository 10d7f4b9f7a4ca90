"""Telling draws from values."""

from __future__ import annotations

from hypgen.dsl import ast, builtins, ir
from hypgen.dsl.mistakes import Mistake, mistake
from hypgen.dsl.scope import Scope
from hypgen.dsl.source import Span


def is_draw(node: ast.Expr) -> bool:
    """Return whether ``node`` is a distribution: a draw, or a choice with one among its results."""
    match node:
        case ast.TableLiteral():
            return True
        case ast.Call(_, name):
            return name in builtins.DRAWS | builtins.LATER_DRAWS
        case ast.Quantified(_, kind):
            return kind in builtins.DRAWS | builtins.LATER_DRAWS
        case ast.If(_, _, then, otherwise):
            return is_draw(then) or is_draw(otherwise)
        case ast.Match(_, _, arms):
            return any(is_draw(a.body) for a in arms)
        case ast.LetIn(_, _, _, body) | ast.Comprehension(_, _, body):
            return is_draw(body)
    return False


def misplaced_draw(what: str, span: Span) -> Mistake:
    """Return the mistake of using a draw as if it were a value."""
    return mistake(
        "E0702",
        f"{what} is a draw, and a function of a draw has no meaning here",
        span,
        "name the draw with 'let name ~ ...' in an element and read the name",
    )


def bind_value(node: ast.LetIn, scope: Scope) -> tuple[ir.Expr, Scope]:
    """Return the value of ``let .. in`` and the scope of its body."""
    if is_draw(node.value):
        raise misplaced_draw("the value of this 'let'", node.value.span)
    value = scope.check(node.value)
    local = value if isinstance(value, ir.Const) else ir.Local(value.type, node.name)
    return value, scope.bind(node.name, local, node.span)
