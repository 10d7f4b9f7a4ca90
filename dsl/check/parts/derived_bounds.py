# SPDX-License-Identifier: Apache-2.0
"""Bounds that follow from the rewards, where the author declares none."""

from __future__ import annotations

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


def derived(name: str, parts: Parts, declared: Declarations, program: Program) -> ir.Expr:
    """Return ``bound upper`` or ``bound tail`` from the least or largest reward of a step.

    The tail is what the default policy earns, so that its rewards alone count if it always takes one action.
    Params count as they are when a solver starts. Where the discount has a mistake, that is all to be told.
    """
    upper, discount, horizon = name == "upper", parts.discount, parts.horizon
    if discount is None:
        raise Mistake
    if discount == 1 and horizon is None:
        setting = (i.span for i in program.file.items if isinstance(i, ast.Setting) and i.kind == "discount")
        raise Mistake(e08_parts.infinite_return(next(setting)))
    action = None if upper else _constant_action(parts, program)
    limits = ParamLimits(declared.params, (*declared.functions, *program.unrolled.values()), declared.lets)
    terms = [_term(r, upper, action, name, limits, program) for r in parts.rewards]
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
    reward: ir.Reward, upper: bool, action: ir.Const | None, name: str, limits: ParamLimits, program: Program
) -> float | ir.Expr:
    """Return the most (or least) that all members earn: a number, or an expression of params."""
    value = reward.value
    if action is not None:
        scope = replace(element_scope(program, reward.element, None), evaluate=True, action=action)
        with suppress(Mistake):  # too long to evaluate: then all actions count
            value = scope.check(_source(reward, program))
    end = operators.ends(value.type)[1 if upper else 0]
    if abs(end) < INT32_MAX:  # what ends there is a param of type int, whose value says more
        return float(end) * (1 if reward.binder is None else size_of(reward.binder.type))
    try:
        return limits.of_sum(value, reward.binder)[1 if upper else 0]
    except Unlimited:
        undefined = may_be_undefined((value,), limits.functions)
        raise Mistake(e06_ranges.unlimited_reward(name, reward.name, undefined, reward.span)) from None


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
