# SPDX-License-Identifier: Apache-2.0
"""``match``: exhaustive choices over enums, booleans and ints, lowered to chains of conditions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from hypgen.dsl import ir
from hypgen.dsl.check.scope.fit_type import unify
from hypgen.dsl.check.scope.let_bindings import let_in
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.terms.references import is_atomic
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e02_names, e03_match, e03_types
from hypgen.dsl.messages.report import Mistake, gather, unreachable
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Bool, Enum, Int, Type

T = TypeVar("T")
_MAX_LISTED = 64


@dataclass(frozen=True)
class Case:
    """An arm that can be reached: when, what it binds, and in which scope its body is checked."""

    condition: ir.Expr
    binding: tuple[str, ir.Expr] | None
    scope: Scope
    body: ast.Expr


def check(node: ast.Match, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return the value of a match."""
    scrutinee, found = cases(node, scope, lambda n, s: s.check(n, expected))
    first = next((c for c in found if not _is_bare(c)), found[0])
    target = expected
    if target is None:
        seen = first.scope.check(first.body).type
        target = seen if isinstance(seen, Enum) else None
    bodies = gather([partial(c.scope.check, c.body, target) for c in found])
    bodies = unify([(b, c.body.span) for b, c in zip(bodies, found, strict=True)], expected)
    return fold(scrutinee, found, bodies, operators.choose, let_in)


def _is_bare(case: Case) -> bool:
    return isinstance(case.body, ast.Name) and case.body.name in case.scope.program.symbols.variants


def fold(
    scrutinee: tuple[str, ir.Expr] | None,
    found: list[Case],
    bodies: list[T],
    choose: Callable[[ir.Expr, T, T], T],
    let: Callable[[str, ir.Expr, T], T],
) -> T:
    """Return the chain of conditions over the arms' bodies; the last arm needs none."""
    bound = [let(*c.binding, b) if c.binding else b for c, b in zip(found, bodies, strict=True)]
    result = bound[-1]
    for case, body in zip(reversed(found[:-1]), reversed(bound[:-1]), strict=True):
        result = choose(case.condition, body, result)
    return let(*scrutinee, result) if scrutinee else result


def cases(
    node: ast.Match, scope: Scope, check_dead: Callable[[ast.Expr, Scope], object]
) -> tuple[tuple[str, ir.Expr] | None, list[Case]]:
    """Return what to bind the scrutinee to, if it is no plain read, and the arms that can be reached.

    The bodies of other arms are passed to ``check_dead`` alone.
    """
    value = scope.check(node.scrutinee)
    matched = value.type
    if not isinstance(matched, Enum | Bool | Int):
        raise Mistake(e03_types.match_of_other(matched, node.scrutinee.span))
    if not node.arms:
        raise Mistake(e03_match.no_arms(node.span))
    binding = None
    if not is_atomic(value):
        name = scope.fresh("matched")
        binding, value = (name, value), ir.Local(value.type, name)
        scope = scope.hide(name, value)
    known = isinstance(value, ir.Const) and (scope.evaluate or bool(scope.unrolling))
    _check_coverage(node, matched, known)
    live: list[Case] = []
    for arm in node.arms:
        case = _case(arm, value, scope)
        scope = scope.given(case.condition, False)
        if operators.is_false(case.condition) or (live and operators.is_true(live[-1].condition)):
            if not scope.evaluate and not scope.unrolling:
                unreachable(partial(check_dead, case.body, case.scope))
            continue
        live.append(case)
    return binding, live


def _case(arm: ast.Arm, value: ir.Expr, scope: Scope) -> Case:
    condition: ir.Expr = operators.FALSE
    for pattern in arm.patterns:
        condition = operators.either(condition, _test(pattern, value))
    inner = scope.given(condition)
    pattern = arm.patterns[0]
    if pattern.argument is None:
        return Case(condition, None, inner, arm.body)
    assert isinstance(value.type, Enum) and pattern.name is not None
    argument = operators.variant_argument(value.type, pattern.name, value)
    if isinstance(argument, ir.Const):
        return Case(condition, None, inner.bind(pattern.argument, argument, pattern.span), arm.body)
    local = ir.Local(argument.type, pattern.argument)
    return Case(
        condition, (pattern.argument, argument), inner.bind(pattern.argument, local, pattern.span), arm.body
    )


def _test(pattern: ast.Pattern, value: ir.Expr) -> ir.Expr:
    if pattern.is_else:
        return operators.TRUE
    if isinstance(value.type, Enum):
        assert pattern.name is not None
        return operators.is_variant(value.type, pattern.name, value)
    if isinstance(value.type, Bool):
        return value if _key(pattern) else operators.invert(value)
    assert pattern.value is not None
    return operators.compare("eq", value, operators.integer(int(pattern.value)))


def _key(pattern: ast.Pattern) -> str | int | bool:
    """Return what a pattern other than ``else`` stands for."""
    if pattern.name in ("true", "false"):
        return pattern.name == "true"
    if pattern.value is not None:
        return pattern.value
    assert pattern.name is not None
    return pattern.name


def _check_coverage(node: ast.Match, t: Enum | Bool | Int, known: bool) -> None:
    """Raise unless the patterns fit the type, none is in vain, and together they cover it."""
    seen: set[str | int | bool] = set()
    closed = False
    for arm in node.arms:
        for pattern in arm.patterns:
            if closed:
                raise Mistake(e03_match.behind_else(pattern.span))
            if pattern.is_else:
                closed = True
                continue
            _check_pattern(pattern, t, alone=len(arm.patterns) == 1, known=known)
            key = _key(pattern)
            if key in seen:
                raise Mistake(e03_match.covered_before(_shown(key), pattern.span))
            seen.add(key)
    missing = [] if closed else _missing(t, seen)
    if missing:
        raise Mistake(e03_match.left_out(missing, node.span))


def _missing(t: Enum | Bool | Int, seen: set[str | int | bool]) -> list[str]:
    if isinstance(t, Enum):
        return [v.name for v in t.variants if v.name not in seen]
    if isinstance(t, Bool):
        return [_shown(b) for b in (True, False) if b not in seen]
    missing = []
    for value in range(t.low, min(t.high, t.low + _MAX_LISTED) + 1):
        if value not in seen:
            missing.append(str(value))
        if len(missing) > 3:
            return [*missing[:3], "and more"]
    return missing or (["values"] if t.high - t.low >= _MAX_LISTED and len(seen) <= t.high - t.low else [])


def _shown(key: str | int | bool) -> str:
    return str(key).lower() if isinstance(key, bool) else str(key)


def _check_pattern(pattern: ast.Pattern, t: Enum | Bool | Int, *, alone: bool, known: bool) -> None:
    key = _key(pattern)
    if isinstance(t, Enum):
        if not isinstance(key, str):
            raise Mistake(e03_match.not_a_variant(t, pattern.span))
        variant = t.variant(key)
        if variant is None:
            raise Mistake(e02_names.unknown_variant(t, key, pattern.span))
        if pattern.argument is not None and variant.argument is None:
            raise Mistake(e03_match.variant_without_argument(key, pattern.span))
        name, carried = pattern.argument, variant.argument
        if name is not None and isinstance(carried, Enum) and carried.variant(name) is not None:
            raise Mistake(e03_match.value_as_name(key, name, carried, pattern.span))
        if pattern.argument is not None and not alone:
            raise Mistake(e03_match.argument_of_alternatives(pattern.span))
        return
    if pattern.argument is not None or isinstance(key, str) or isinstance(key, bool) != isinstance(t, Bool):
        raise Mistake(e03_match.other_kind(t, pattern.span))
    if isinstance(t, Int) and not known and not t.low <= key <= t.high:
        raise Mistake(e03_match.never_occurs(key, t, pattern.span))
