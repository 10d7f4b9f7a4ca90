"""Checking distributions: what may stand after ``~``."""

from __future__ import annotations

from functools import partial

from hypgen.dsl import ast, builtins, ir, matching, operators
from hypgen.dsl.bindings import let_dist
from hypgen.dsl.draws import bind_value, is_draw
from hypgen.dsl.mistakes import gather, later, mistake, unreachable
from hypgen.dsl.quantifiers import bind_all, bind_types
from hypgen.dsl.scope import Scope
from hypgen.dsl.source import Span
from hypgen.dsl.type_expressions import require_finite
from hypgen.dsl.typecheck import check_as, fit, mismatch
from hypgen.dsl.types import BOOL, PROB, Int, Type

_SUM_TOLERANCE = 1e-6


def right_side(rhs: ast.Rhs, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return what ``= e`` or ``~ d`` says, as a distribution over ``target`` (None: as found)."""
    if not rhs.draw and is_draw(rhs.expr):
        raise mistake(
            "E0701", "this is a draw, and '=' is exact", rhs.span, "write '~' in place of '=' to draw"
        )
    return check(rhs.expr, scope, target, what)


def check(node: ast.Expr, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return the distribution that ``node`` writes, over ``target`` if that is given."""
    if isinstance(node, ast.Comprehension | ast.ArrayLiteral):
        raise mistake(
            "E0706",
            "an array stands where one value is drawn",
            node.span,
            "give a value or draw of one entry",
        )
    if target is None and not is_draw(node):
        value = scope.check(node)
        return ir.Certain(value.type, value)
    match node:
        case ast.If():
            return _conditional(node, scope, target, what)
        case ast.LetIn():
            value, inner = bind_value(node, scope)
            return let_dist(node.name, value, check(node.body, inner, target, what))
        case ast.Match():
            return _match(node, scope, target, what)
        case ast.TableLiteral():
            return _table(node, scope, target, what)
        case ast.Call(_, "bernoulli"):
            return _bernoulli(node, scope, target, what)
        case ast.Call(_, "noisy"):
            return _noisy(node, scope, target, what)
        case ast.Call(_, "uniform"):
            return _uniform(node, scope, target, what)
        case ast.Quantified(_, "uniform"):
            return _uniform_set(node, scope, target, what)
        case ast.Call(span, name) if name in builtins.LATER_DRAWS:
            raise later(f"'{name}'", span)
        case ast.Quantified(span, kind) if kind in builtins.LATER_DRAWS:
            raise later(f"'{kind}'", span)
    if target is None:
        raise AssertionError(node)  # is_draw told it for a draw
    return ir.Certain(target, check_as(node, scope, target, what))


def choose(condition: ir.Expr, then: ir.Dist, otherwise: ir.Dist) -> ir.Dist:
    """Return one of two distributions; of two certain ones, the certain choice."""
    if isinstance(condition, ir.Const):
        return then if condition.value else otherwise
    if isinstance(then, ir.Certain) and isinstance(otherwise, ir.Certain):
        return ir.Certain(then.type, operators.choose(condition, then.value, otherwise.value))
    return ir.IfDist(then.type, condition, then, otherwise)


def _joined(branches: list[tuple[ir.Dist, Span]], what: str) -> list[ir.Dist]:
    """Return branches of one type, which is what they have in common."""
    common = branches[0][0].type
    for dist, span in branches[1:]:
        joined = operators.join(common, dist.type)
        if joined is None:
            raise mismatch(common, dist.type, span, what)
        common = joined
    return [_typed(dist, common) for dist, _ in branches]


def _typed(dist: ir.Dist, t: Type) -> ir.Dist:
    """Return ``dist`` over a wider type."""
    if dist.type == t:
        return dist
    match dist:
        case ir.Certain(_, value):
            return ir.Certain(t, value)
        case ir.IfDist(_, condition, then, otherwise):
            return ir.IfDist(t, condition, _typed(then, t), _typed(otherwise, t))
        case ir.LetDist(_, name, value, body):
            return ir.LetDist(t, name, value, _typed(body, t))
        case ir.Table(_, entries, rest):
            return ir.Table(t, entries, rest)
        case ir.UniformSet(_, binders, condition, value, otherwise):
            return ir.UniformSet(
                t, binders, condition, value, None if otherwise is None else _typed(otherwise, t)
            )
        case ir.Uniform(own):
            return _uniform_over(own, t)
    raise AssertionError(dist)


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
        then, otherwise = _joined([(then, node.then.span), (otherwise, node.otherwise.span)], what)
    return choose(condition, then, otherwise)


def _match(node: ast.Match, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    scrutinee, cases = matching.cases(node, scope, lambda n, s: check(n, s, target, what))
    bodies = gather([partial(check, c.body, c.scope, target, what) for c in cases])
    if target is None:
        bodies = _joined([(b, c.body.span) for b, c in zip(bodies, cases, strict=True)], what)
    return matching.fold(scrutinee, cases, bodies, choose, let_dist)


def _arguments(node: ast.Call, count: int, form: str) -> None:
    if len(node.arguments) != count:
        raise mistake(
            "E0302",
            f"'{node.name}' takes {count} argument{'' if count == 1 else 's'}, but {len(node.arguments)} "
            f"{'is' if len(node.arguments) == 1 else 'are'} given",
            node.span,
            f"its form is {form}",
        )


def probability(node: ast.Expr, scope: Scope) -> ir.Expr:
    """Return a probability; a constant one must lie in 0 .. 1."""
    return check_as(node, scope, PROB, "the probability", "E0606")


def _bernoulli(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    _arguments(node, 1, "bernoulli(p)")
    p = probability(node.arguments[0], scope)
    if target not in (None, BOOL):
        assert target is not None
        raise mismatch(target, BOOL, node.span, what)
    return ir.Bernoulli(BOOL, p)


def _noisy(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    _arguments(node, 2, "noisy(value, p)")
    if target is None:
        value = scope.check(node.arguments[0])
        if isinstance(value.type, Int):
            raise mistake(
                "E0705",
                "which other values this noisy draw can give is not known",
                node.span,
                "give the let a type: let name: T ~ noisy(..)",
            )
    else:
        value = check_as(node.arguments[0], scope, target, what)
    t = target or value.type
    require_finite(t, node.span, "a noisy draw")
    return ir.Noisy(t, value, probability(node.arguments[1], scope))


def _uniform(node: ast.Call, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    if len(node.arguments) == 2:
        raise later("a draw from an interval", node.span, "draw from a finite type: uniform(T)")
    _arguments(node, 1, "uniform(T)")
    argument = node.arguments[0]
    if not isinstance(argument, ast.Name):
        raise mistake("E0705", "uniform(..) takes a type", argument.span, "name a finite type")
    found = scope.program.type_of(ast.TypeName(argument.span, argument.name))
    require_finite(found, argument.span, "a uniform draw")
    if target is None:
        return ir.Uniform(found)
    if isinstance(target, Int) and isinstance(found, Int):
        fit(ir.Local(found, argument.name), target, node.span, what)
    elif target != found:
        raise mismatch(target, found, node.span, what)
    return _uniform_over(found, target)


def _uniform_over(own: Type, target: Type) -> ir.Dist:
    """Return the uniform draw from ``own`` as a distribution over ``target``, which may be wider."""
    if own == target:
        return ir.Uniform(own)
    return ir.UniformSet(target, (ir.Binder("value_1", own),), None, ir.Local(own, "value_1"), None)


def _uniform_set(node: ast.Quantified, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    binders = bind_types(node.binders, scope)
    inner = bind_all(node.binders, binders, scope)
    condition = (
        None if node.where is None else check_as(node.where, inner, BOOL, "the condition after 'where'")
    )
    if condition is not None:
        inner = inner.given(condition)
    if condition is not None and operators.is_false(condition) and node.otherwise is None:
        raise mistake("E0608", "this draws from an empty set", node.span, "add 'else value'")
    body = node.body
    if body is None:
        if len(binders) != 1:
            raise mistake("E0705", "what to draw is not said", node.span, "add ': value' after the binders")
        body = ast.Name(node.binders[0].span, binders[0].name)
    value = inner.check(body, target)
    if target is not None:
        value = fit(value, target, body.span, what)
    t = target or (binders[0].type if node.body is None else value.type)
    otherwise = None if node.otherwise is None else check(node.otherwise, scope, t, what)
    return ir.UniformSet(t, binders, condition, value, otherwise)


def _table(node: ast.TableLiteral, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    values = [n for n, _ in node.entries] + ([] if node.rest is None else [node.rest])
    if not node.entries:
        raise mistake(
            "E0703", "the table has no weights", node.span, "write {value: probability, else other}"
        )
    if target is None:
        found = gather([partial(scope.check, n) for n in values])
        for e, n in zip(found, values, strict=True):
            joined = operators.join(target or e.type, e.type)
            if joined is None:
                raise mismatch(target or e.type, e.type, n.span, what)
            target = joined
    assert target is not None
    checked = gather([partial(check_as, n, scope, target, what) for n in values])
    weights = gather([partial(probability, p, scope) for _, p in node.entries])
    _check_sum(node, weights)
    rest = None if node.rest is None else checked[-1]
    return ir.Table(target, tuple(zip(checked, weights, strict=False)), rest)


def _check_sum(node: ast.TableLiteral, weights: list[ir.Expr]) -> None:
    constant = [float(w.value) for w in weights if isinstance(w, ir.Const)]
    total = sum(constant)
    if node.rest is not None:
        wrong = total > 1 + _SUM_TOLERANCE
        remedy = "weights and 'else' together are 1: make the weights smaller"
    else:
        wrong = len(constant) == len(weights) and abs(total - 1) > _SUM_TOLERANCE
        remedy = "make them sum to 1, or give the remainder to 'else value'"
    if wrong:
        raise mistake("E0703", f"the weights sum to {total:g}", node.span, remedy)
