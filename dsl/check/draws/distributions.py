# SPDX-License-Identifier: Apache-2.0
"""Checking distributions: what may stand after ``~``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.draws import limited_draws, nested_draws, number_draws, set_draws
from hypgen.dsl.check.draws.fit_distribution import fitted, in_variant, joined
from hypgen.dsl.check.draws.named_distributions import inlined
from hypgen.dsl.check.draws.number_draws import refuse_unlimited
from hypgen.dsl.check.expressions.calls import variant_with_argument
from hypgen.dsl.check.expressions.expressions import enter_prime, require_state
from hypgen.dsl.check.scope.draw_syntax import bind_value, is_draw, named_draw, refuse_fields
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.let_bindings import let_dist
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.type_expressions import require_finite
from hypgen.dsl.check.terms import matching, references
from hypgen.dsl.ir import masses, operators
from hypgen.dsl.ir.nodes import placed
from hypgen.dsl.messages import e03_calls, e03_types, e07_draws
from hypgen.dsl.messages.report import Mistake, gather, unreachable
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, PROB, Enum, Float, Int, Type, builtin_names

_SUM_TOLERANCE = 1e-6
# Reads whose range is declared, not found by analysis.
_DECLARED = ir.StateRead | ir.ParamRead | ir.TableRead | ir.ActionRead | ir.Local | ir.FieldRead
_FORMS = {
    "bernoulli": ((1,), "bernoulli(p)"),
    "noisy": ((2,), "noisy(value, p)"),
    "uniform": ((1, 2), "uniform(T) or uniform(low, high)"),
    "normal": ((2,), "normal(mean, sd)"),
    "exponential": ((1,), "exponential(mean)"),
    "poisson": ((1,), "poisson(mean)"),
    "binomial": ((2,), "binomial(n, p)"),
    "truncated": ((3,), "truncated(draw, low, high)"),
    "binned": ((3,), "binned(draw, low, high)"),
    "clamp": ((1, 3), "clamp(draw) or clamp(draw, low, high)"),
    "weighted": ((), "weighted(i in T: weight)"),
}


def right_side(rhs: ast.Rhs, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return what ``= e`` or ``~ d`` says, as a distribution over ``target`` (None: as found)."""
    if not rhs.draw and is_draw(rhs.expr, scope):
        refuse_fields(rhs.expr, target)
        raise Mistake(e07_draws.draw_behind_equals(rhs.span))
    try:
        dist = check(rhs.expr, scope, target, what)
    except Mistake:
        _refuse_probability(rhs, scope, target, what)
        raise
    refuse_unlimited(dist, rhs.expr.span)
    return dist


def check(node: ast.Expr, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return the distribution that ``node`` writes, over ``target`` if that is given."""
    return placed(_check(node, scope, target, what), node.span)


def _check(node: ast.Expr, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    if (
        isinstance(node, ast.ArrayLiteral)
        and isinstance(target, Enum)
        and len(node.items) == len(target.variants)
        and all(isinstance(i, ast.Literal) for i in node.items)
    ):
        raise Mistake(e07_draws.list_of_probabilities([v.name for v in target.variants], node.span))
    if isinstance(node, ast.Comprehension | ast.ArrayLiteral):
        raise Mistake(e07_draws.array_for_draw(target, node.span))
    if target is None and not is_draw(node, scope):
        value = scope.check(node)
        return ir.Certain(value.type, value)
    match node:
        case ast.If(_, condition) if is_draw(condition, scope):
            return nested_draws.named(
                *(condition, BOOL, scope),
                lambda name, inner: check(replace(node, condition=name), inner, target, what),
            )
        case ast.If():
            return _conditional(node, scope, target, what)
        case ast.LetIn(draw=True):
            return nested_draws.let_in(node, scope, target, what)
        case ast.LetIn():
            value, inner = bind_value(node, scope)
            return let_dist(node.name, value, check(node.body, inner, target, what))
        case ast.Match(_, scrutinee) if is_draw(scrutinee, scope):
            return nested_draws.named(
                *(scrutinee, None, scope),
                lambda name, inner: check(replace(node, scrutinee=name), inner, target, what),
            )
        case ast.Match():
            return _match(node, scope, target, what)
        case ast.TableLiteral():
            return _table(node, scope, target, what)
        case ast.Prime(_, ast.Call() as call) if is_draw(node, scope):
            inner = enter_prime(node, scope)
            require_state(node, scope)
            return check(call, inner, target, what)
        case ast.Call(_, name, arguments) if _takes_values(name, arguments, scope):
            return nested_draws.lifted(node, scope, target, what)
        case ast.Call(_, name) if item := named_draw(name, scope):
            return inlined(node, item, scope, target, what)
        case ast.Call(_, name) if name in scope.program.symbols.variants and is_draw(node, scope):
            enum, own = variant_with_argument(node, scope, target)
            drawn = check(node.arguments[0], scope, own, f"the argument of '{name}'")
            return fitted(in_variant(drawn, enum, name), target, node.span, what)
        case ast.Call() if is_draw(node, scope):
            _check_form(node)
            return _CALLS[node.name](node, scope, target, what)
        case _ if isinstance(node, nested_draws.STRICT) and is_draw(node, scope):
            return nested_draws.lifted(node, scope, target, what)
        case ast.Quantified(_, "uniform"):
            return set_draws.uniform_set(node, scope, target, what)
        case ast.Quantified(_, "weighted"):
            return set_draws.weighted(node, scope, target, what)
    if target is None:
        raise AssertionError(node)  # is_draw told it for a draw
    _refuse_row(node, scope, target)
    return ir.Certain(target, check_as(node, scope, target, what))


def _refuse_probability(rhs: ast.Rhs, scope: Scope, target: Type | None, what: str) -> None:
    """Raise if a draw of a truth value is written as its probability: one mistake, however many branches."""
    if not rhs.draw or target != BOOL or is_draw(rhs.expr, scope):
        return
    try:
        value = scope.check(rhs.expr)
    except Mistake:
        return
    if isinstance(value.type, Float):
        raise Mistake(e03_types.probability_for_draw(what, rhs.expr.span)) from None


def _refuse_row(node: ast.Expr, scope: Scope, target: Type) -> None:
    """Raise if a row of a matrix stands for a draw by its entries."""
    reference = references.find(node.operand, scope) if isinstance(node, ast.Index) else None
    if isinstance(node, ast.Index) and reference is not None:
        types = reference.indices
        if len(types) == len(node.indices) + 1 and types[-1] == target:
            raise Mistake(e07_draws.row_of_matrix(reference.label, target, node.span))


def _takes_values(name: str, arguments: tuple[ast.Expr, ...], scope: Scope) -> bool:
    """Return whether a call is given a draw where it takes a value: a draw of a draw is no such call."""
    if name in builtin_names.DRAWS | builtin_names.HISTORY | builtin_names.CUMULATIVE or (
        name == "clamp" and arguments and is_draw(arguments[0], scope)
    ):
        return False
    return name not in scope.program.symbols.variants and any(is_draw(n, scope) for n in arguments)


def choose(condition: ir.Expr, then: ir.Dist, otherwise: ir.Dist) -> ir.Dist:
    """Return one of two distributions; of two certain ones, the certain choice."""
    if isinstance(condition, ir.Const):
        return then if condition.value else otherwise
    if isinstance(then, ir.Certain) and isinstance(otherwise, ir.Certain):
        return ir.Certain(then.type, operators.choose(condition, then.value, otherwise.value))
    return ir.IfDist(operators.join(then.type, otherwise.type) or then.type, condition, then, otherwise)


def _conditional(node: ast.If, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    condition = check_as(node.condition, scope, BOOL, "the condition of 'if'")
    if isinstance(condition, ir.Const):
        live, dead = (node.then, node.otherwise) if condition.value else (node.otherwise, node.then)
        unreachable(partial(check, dead, scope, target, what))
        return check(live, scope, target, what)
    then, otherwise = gather(
        [
            partial(check, node.then, scope.given(condition), target, what),
            partial(check, node.otherwise, scope.given(condition, False), target, what),
        ]
    )
    if target is None:
        then, otherwise = joined([(then, node.then.span), (otherwise, node.otherwise.span)], what)
    return choose(condition, then, otherwise)


def _match(node: ast.Match, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    scrutinee, cases = matching.cases(node, scope, lambda n, s: check(n, s, target, what))
    bodies = gather([partial(check, c.body, c.scope, target, what) for c in cases])
    if target is None:
        bodies = joined([(b, c.body.span) for b, c in zip(bodies, cases, strict=True)], what)
    return matching.fold(scrutinee, cases, bodies, choose, let_dist)


def _check_form(node: ast.Call) -> None:
    """Raise unless a built-in draw is given as many arguments as it takes."""
    counts, form = _FORMS[node.name]
    given = len(node.arguments)
    if given not in counts:
        raise Mistake(e03_calls.wrong_arguments_of_draw(node.name, counts, given, form, node.span))


def probability(node: ast.Expr, scope: Scope) -> ir.Expr:
    """Return a probability; a constant one must lie in 0 .. 1."""
    return placed(check_as(node, scope, PROB, "the probability"), node.span)


def _bernoulli(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    p = probability(node.arguments[0], scope)
    if target not in (None, BOOL):
        assert target is not None
        raise Mistake(e03_types.mismatch(what, target, BOOL, node.span))
    return ir.Bernoulli(BOOL, p, masses.complement(p))


def _noisy(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    if target is None:
        value = replace(scope, facts={}).check(node.arguments[0])
        if isinstance(value.type, Int) and not isinstance(value, _DECLARED):
            raise Mistake(e07_draws.noisy_without_type(node.span))
    else:
        value = check_as(node.arguments[0], scope, target, what)
    t = target or value.type
    require_finite(t, node.span, "a noisy draw")
    p = probability(node.arguments[1], scope)
    return ir.Noisy(t, value, p, masses.complement(p))


def _uniform(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    form = set_draws.uniform_type if len(node.arguments) == 1 else number_draws.check
    return form(node, scope, target, what)


def _table(node: ast.TableLiteral, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    values = [n for n, _ in node.entries] + ([] if node.rest is None else [node.rest])
    if not node.entries:
        raise Mistake(e07_draws.no_weights(node.span))
    first = node.entries[0][0]
    if isinstance(first, ast.Literal) and isinstance(first.value, float) and isinstance(target, Int | Enum):
        raise Mistake(e07_draws.swapped_entries(first.span))
    if any(is_draw(n, scope) for n in values):
        weights = _weights(node, scope)
        return nested_draws.mixture(node, weights, _complements(weights), scope, target, what)
    if target is None:
        found = gather([partial(scope.check, n) for n in values])
        for e, n in zip(found, values, strict=True):
            joined = operators.join(target or e.type, e.type)
            if joined is None:
                raise Mistake(e03_types.mismatch(what, target or e.type, e.type, n.span))
            target = joined
    assert target is not None
    checked = gather([partial(check_as, n, scope, target, what) for n in values])
    weights = _weights(node, scope)
    rest = None if node.rest is None else checked[-1]
    return ir.Table(target, tuple(zip(checked, weights, strict=False)), rest, _complements(weights))


def _weights(node: ast.TableLiteral, scope: Scope) -> list[ir.Expr]:
    weights = gather([partial(probability, p, scope) for _, p in node.entries])
    _check_sum(node, weights)
    return weights


def _complements(weights: list[ir.Expr]) -> tuple[ir.Expr | None, ...]:
    complements = tuple(map(masses.complement, weights))
    return complements if any(complements) else ()


def _check_sum(node: ast.TableLiteral, weights: list[ir.Expr]) -> None:
    constant = [float(w.value) for w in weights if isinstance(w, ir.Const)]
    total = sum(constant)
    if node.rest is not None and total > 1 + _SUM_TOLERANCE:
        raise Mistake(e07_draws.wrong_sum_with_else(total, node.span))
    if node.rest is None and len(constant) == len(weights) and abs(total - 1) > _SUM_TOLERANCE:
        raise Mistake(e07_draws.wrong_sum(total, node.span))


_CALLS = {
    **dict.fromkeys(builtin_names.NUMBER_DRAWS, number_draws.check),
    "bernoulli": _bernoulli,
    "noisy": _noisy,
    "uniform": _uniform,
    "truncated": limited_draws.truncated,
    "clamp": limited_draws.clamped,
    "binned": limited_draws.binned,
}
