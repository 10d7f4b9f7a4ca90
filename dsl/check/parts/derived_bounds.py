# SPDX-License-Identifier: Apache-2.0
"""Bounds that follow from the rewards, where the author declares none."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.check.parts.declarations import element_scope
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.undefined import may_be_undefined
from hypgen.dsl.messages import e06_ranges, e08_parts
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import intervals, size_of

_SLACK = 2.0**-20


def derived(name: str, model: ir.Model, program: Program) -> ir.Expr:
    """Return ``bound upper`` or ``bound tail`` from the least or largest reward of a step.

    The tail is what the default policy earns, so that its rewards alone count if it always takes one action.
    """
    upper = name == "upper"
    if model.discount == 1 and model.horizon is None:
        raise Mistake(e08_parts.infinite_return(model.spans["discount"]))
    action = None if upper else _constant_action(model, program)
    step = sum(_term(r, upper, action, name, model, program) for r in model.rewards)
    if not operators.is_false(model.terminal) or model.horizon is not None:
        step = max(step, 0.0) if upper else min(step, 0.0)  # an episode may end at once
    total = step * model.horizon if model.discount == 1 and model.horizon else step / (1 - model.discount)
    return operators.real(_outward(total, upper))


def _outward(value: float, upper: bool) -> float:
    """Return ``value`` as a float32 that is not on its inner side."""
    found = intervals.float32(value)
    if (found < value) if upper else (found > value):
        found = intervals.float32(value + abs(value) * (_SLACK if upper else -_SLACK))
    return found


def _term(
    reward: ir.Reward, upper: bool, action: ir.Const | None, name: str, model: ir.Model, program: Program
) -> float:
    value = reward.value
    if action is not None:
        scope = replace(element_scope(program, reward.element, None), evaluate=True, action=action)
        with suppress(Mistake):  # too long to evaluate: then all actions count
            value = scope.check(_source(reward, program))
    end = operators.ends(value.type)[1 if upper else 0]
    if math.isinf(end):
        undefined = may_be_undefined((value,), {f.name: f for f in model.functions})
        raise Mistake(e06_ranges.unlimited_reward(name, reward.name, undefined, reward.span))
    return end * (1 if reward.binder is None else size_of(reward.binder.type))


def _source(reward: ir.Reward, program: Program) -> ast.Expr:
    items: list[ast.Item] = list(program.file.items)
    for item in program.file.items:
        items += item.members if isinstance(item, ast.Element) else ()
    return next(i.value for i in items if isinstance(i, ast.Reward) and i.span == reward.span)


def _constant_action(model: ir.Model, program: Program) -> ir.Const | None:
    """Return the action (or component of a product action) that the default policy always takes, if legal."""
    if model.policy is None or not isinstance(model.policy.dist, ir.Certain):
        return None
    action = model.policy.dist.value
    if not isinstance(action, ir.Const):
        return None
    scope = replace(element_scope(program, None, None), evaluate=True, action=action)
    conditions = [i for i in program.file.items if isinstance(i, ast.Condition) and i.kind == "legal"]
    with suppress(Mistake):
        if all(operators.is_true(scope.check(c.condition)) for c in conditions):
            return action
    return None
