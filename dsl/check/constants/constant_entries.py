# SPDX-License-Identifier: Apache-2.0
"""The values of constant expressions, one for each value of their binders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import prod

from hypgen.dsl import ir
from hypgen.dsl.check.constants.closures import Closures, Code, Irregular, combinations
from hypgen.dsl.check.scope.fit_type import check_as, fit
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.terms.quantifiers import bind_all
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.messages import e06_ranges, e08_parts
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk
from hypgen.dsl.types import BOOL, Bool, Float, Int, Type, size_of

_MAX_STEPS = 1 << 26  # of closures: some ten seconds
_MAX_CHECKED = 1 << 13  # entries that may be checked one by one: a second


def scalar(node: ast.Expr, scope: Scope, t: Type, what: str) -> ir.Const:
    """Return a constant expression's value, of type ``t``."""
    if _runs_over_values(node):
        for value in values(node, (), scope, t, what):
            return _constant(value, t)
    return _checked(node, scope, t, what)


def values(
    node: ast.Expr,
    bound: tuple[tuple[ast.Binder, ir.Binder], ...],
    scope: Scope,
    t: Type,
    what: str,
    where: tuple[ast.Expr, Sequence[Value]] | None = None,
) -> Iterator[Value]:
    """Yield ``node`` as a ``t`` for all values of the binders, in order; ``scope`` is one of constants.

    ``where`` is a condition and its values: where it does not hold, 0 stands for the value.
    The expression is checked once and run as closures where that tells its value. Where it does not, it is
    checked anew for each value: conditions may then be known that keep it in range.
    """
    binders = tuple(b for _, b in bound)
    count = prod(size_of(b.type) for b in binders)
    general = replace(scope, evaluate=False, constant=False)
    general = bind_all(tuple(n for n, _ in bound), binders, general)
    code: Code | None = None
    try:
        if where is not None:
            general = general.given(general.check(where[0], BOOL))
        e = general.check(node, t)
        e = operators.to_float(e) if isinstance(t, Float) and isinstance(e.type, Int) else e
        if _kind(e.type) != _kind(t):
            fit(e, t, node.span, what)
        closures = Closures(scope.program)
        code = closures.code(e)
        _require_steps(count * closures.cost(e), node.span, what)
    except Irregular:
        pass
    except Mistake as error:
        if count > _MAX_CHECKED or any(d.code == e06_ranges.TOO_MANY_STEPS for d in error.diagnostics):
            raise
    names = [b.name for b in binders]
    env = {n: e.value for n, e in scope.locals.items() if isinstance(e, ir.Const)}
    irregular = 0
    for number, found in enumerate(combinations(binders)):
        if where is not None and not where[1][number]:
            yield 0
            continue
        env.update(zip(names, found, strict=True))
        value = None
        if code is not None:
            try:
                value = code(env)
            except (Irregular, ArithmeticError, ValueError):
                value = None
        if value is None or not fits(value, t):
            irregular += 1
            if irregular > _MAX_CHECKED:
                _require_steps(_MAX_STEPS + 1, node.span, what)
            constants = {b.name: _constant(v, b.type) for b, v in zip(binders, found, strict=True)}
            inner = replace(scope, locals={**scope.locals, **constants})
            value = _checked(node, inner, t, what).value
        yield value


def _checked(node: ast.Expr, scope: Scope, t: Type, what: str) -> ir.Const:
    e = check_as(node, scope, t, what)
    if not isinstance(e, ir.Const):
        raise Mistake(e08_parts.not_constant(what, node.span))
    return e


def _constant(value: Value, t: Type) -> ir.Const:
    return operators.literal(value) if isinstance(t, Int | Float | Bool) else ir.Const(t, value)


def _kind(t: Type) -> object:
    """Return what must agree for closures' values to be values of ``t``."""
    return type(t) if isinstance(t, Int | Float) else t


def fits(value: Value, t: Type) -> bool:
    """Return whether a number lies in the range of ``t``."""
    match t:
        case Int(low, high):
            return low <= value <= high
        case Float(prob=True):
            return 0 <= value <= 1
    return True


def _require_steps(steps: int, span: Span, what: str) -> None:
    if steps > _MAX_STEPS:
        raise Mistake(e06_ranges.many_steps_of_constant(what, span))


def _runs_over_values(node: ast.Expr) -> bool:
    return any(isinstance(part, ast.Quantified) for part in walk(node))
