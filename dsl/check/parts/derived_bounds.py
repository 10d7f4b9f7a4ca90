# SPDX-License-Identifier: Apache-2.0
"""Bounds that follow from the rewards, where the author declares none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial, reduce

from hypgen.dsl import ir
from hypgen.dsl.check.parts.all_parts import Declarations, Parts
from hypgen.dsl.check.parts.declarations import element_scope
from hypgen.dsl.check.parts.param_limits import ParamLimits, Unlimited
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.undefined import may_be_undefined
from hypgen.dsl.messages import e06_ranges, e08_parts
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT32_MAX, intervals, size_of

_SLACK = 2.0**-20
Term = float | ir.Expr  # the most (or least) that a reward earns: a number, or an expression of params


def derived(
    names: Iterable[str], parts: Parts, declared: Declarations, program: Program
) -> Mapping[str, ir.Expr]:
    """Return those named of ``bound upper`` and ``bound tail``, from the largest and least reward of a step.

    The tail is what the default policy earns, so that its rewards alone count if it always takes one action.
    Params count as they are when a solver starts. Where the discount has a mistake, that is all to be told.
    A reward that nothing limits is told once, with both bounds that it keeps from being derived.
    """
    found: dict[str, list[Term]] = {name: [] for name in names}
    if not found:
        return {}
    if parts.discount is None:
        raise Mistake
    if parts.discount == 1 and parts.horizon is None:
        setting = (i.span for i in program.file.items if isinstance(i, ast.Setting) and i.kind == "discount")
        raise Mistake(e08_parts.infinite_return(next(setting)))
    limits = ParamLimits(declared.params, (*declared.functions, *program.unrolled.values()), declared.lets)
    action = _constant_action(parts, program)
    for reward in parts.rewards:
        terms = {
            name: _term(reward, name == "upper", None if name == "upper" else action, limits, program)
            for name in found
        }
        lacking = [name for name, term in terms.items() if term is None]
        if lacking:
            undefined = may_be_undefined((reward.value,), limits.functions)
            raise Mistake(e06_ranges.unlimited_reward(lacking, reward.name, undefined, reward.span))
        for name, term in terms.items():
            assert term is not None
            found[name].append(term)
    return {name: _bound(name == "upper", terms, parts) for name, terms in found.items()}


def _bound(upper: bool, terms: list[Term], parts: Parts) -> ir.Expr:
    """Return a bound from the most (or least) that each reward earns in a step."""
    discount, horizon = parts.discount, parts.horizon
    assert discount is not None
    steps = float(horizon) if discount == 1 and horizon else 1 / (1 - discount)
    # An episode may end at once.
    ends = parts.terminal is not None and not operators.is_false(parts.terminal) or horizon is not None
    step = sum(t for t in terms if isinstance(t, float))
    open_terms = [t for t in terms if isinstance(t, ir.Expr)]
    if not open_terms:
        if ends:
            step = max(step, 0.0) if upper else min(step, 0.0)
        return operators.real(_outward(step * steps, upper))
    most = reduce(partial(operators.arithmetic, "add"), open_terms)
    if step:
        most = operators.arithmetic("add", most, operators.real(step))
    if ends:
        most = operators.arithmetic("max" if upper else "min", most, operators.real(0.0))
    total = operators.arithmetic("mul", most, operators.real(steps))
    named = ir.Local(total.type, "total%")
    slack = operators.arithmetic("mul", operators.absolute(named), operators.real(_SLACK))
    outward = operators.arithmetic("add" if upper else "sub", named, slack)
    return ir.LetIn(outward.type, named.name, total, outward)


def _outward(value: float, upper: bool) -> float:
    """Return ``value`` as a float32 that is not on its inner side."""
    found = intervals.float32(value)
    if (found < value) if upper else (found > value):
        found = intervals.float32(value + abs(value) * (_SLACK if upper else -_SLACK))
    return found


def _term(
    reward: ir.Reward, upper: bool, action: ir.Const | None, limits: ParamLimits, program: Program
) -> Term | None:
    """Return the most (or least) that all members earn; None where nothing limits it."""
    value, end = reward.value, _end(reward.value, upper)
    if action is not None or end is None:
        scope = replace(element_scope(program, reward.element, None), evaluate=True, action=action)
        try:
            evaluated = scope.check(_source(reward, program))
            value, end = (value if action is None else evaluated), _end(evaluated, upper)
        except Mistake as mistake:  # too long to evaluate: then all actions count
            found = [d for d in mistake.diagnostics if d.code in e06_ranges.WITHOUT_VALUE and end is None]
            if found and action is None:
                note = (reward.span, f"reward '{reward.name}' comes to it")
                raise Mistake(*(replace(d, notes=(*d.notes, note)) for d in found)) from None
    if end is not None:
        return end * (1 if reward.binder is None else size_of(reward.binder.type))
    try:
        found_limit = limits.of_sum(value, reward.binder)[1 if upper else 0]
    except Unlimited:
        return None
    return float(found_limit.value) if isinstance(found_limit, ir.Const) else found_limit


def _end(value: ir.Expr, upper: bool) -> float | None:
    """Return the end of an expression's interval; None where it says nothing."""
    end = operators.ends(value.type)[1 if upper else 0]
    return float(end) if abs(end) < INT32_MAX else None  # what ends there is a param of type int


def _source(reward: ir.Reward, program: Program) -> ast.Expr:
    items: list[ast.Item] = list(program.file.items)
    for item in program.file.items:
        items += item.members if isinstance(item, ast.Element) else ()
    return next(i.value for i in items if isinstance(i, ast.Reward) and i.span == reward.span)


def _constant_action(parts: Parts, program: Program) -> ir.Const | None:
    """Return the action (or component of a product action) that the default policy always takes, if legal."""
    if parts.policy is None or not isinstance(parts.policy.dist, ir.Certain):
        return None
    action = parts.policy.dist.value
    if not isinstance(action, ir.Const):
        return None
    scope = replace(element_scope(program, None, None), evaluate=True, action=action)
    conditions = [i for i in program.file.items if isinstance(i, ast.Condition) and i.kind == "legal"]
    with suppress(Mistake):
        if all(operators.is_true(scope.check(c.condition)) for c in conditions):
            return action
    return None
