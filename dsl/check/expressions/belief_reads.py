# SPDX-License-Identifier: Apache-2.0
"""``belief(e)`` and ``deviation(e)``: mean and standard deviation of ``e`` given what the agent has seen."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.analysis.hidden_reads import Touches, leaves
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check.scope.scope import Asked, Program, Scope
from hypgen.dsl.ir.operators import is_numeric, to_float
from hypgen.dsl.ir.walk import map_children
from hypgen.dsl.messages import e03_calls, e03_types, e04_variables, e05_reads
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Bool, Float
from hypgen.dsl.types.intervals import float32


def _form(function: str) -> str:
    return f"{function}(e), where e reads hidden variables of one element, or of one member of a family"


def belief(node: ast.Call, scope: Scope) -> ir.Expr:
    """Return the read of a belief; whose it is follows when the whole model is known (``resolved``)."""
    if len(node.arguments) != 1:
        given = len(node.arguments)
        raise Mistake(e03_calls.wrong_arguments_of_belief(node.name, given, _form(node.name), node.span))
    if not scope.history:
        raise Mistake(e05_reads.history_outside_policy(node.name, scope.kind, node.span))
    if scope.primed:
        raise Mistake(e04_variables.next_belief(node.name, node.span))
    number = len(scope.program.beliefs)
    asked = Asked(node.span, Owner("belief", str(number), scope.owner), node.name)
    scope.program.beliefs.append(asked)
    operand = replace(scope, owner=asked.owner).check(node.arguments[0])
    if isinstance(operand.type, Bool):
        mean = Float(0.0, 1.0, prob=True)
        operand = ir.ToFloat(mean, operand)
    elif is_numeric(operand.type):
        operand = to_float(operand)
        assert isinstance(operand.type, Float)
        mean = operand.type
    else:
        raise Mistake(e03_types.belief_of_other(node.name, operand.type, node.arguments[0].span))
    known = not (math.isinf(mean.low) or math.isinf(mean.high))
    deviates = node.name == "deviation"
    if deviates:
        mean = Float(0.0, float32((mean.high - mean.low) / 2) if known else math.inf, unit=mean.unit)
    read = ir.BeliefRead(mean, number, "", None, operand, deviates)
    if not known:
        return read
    return ir.Clamp(mean, read, mean.low, mean.high)  # it may be rounded to beyond the ends


def resolved(model: ir.Model, program: Program) -> ir.Model:
    """Return the model with the factor of each ``belief``; reports those that no exact factor answers."""
    return _Resolver(model, program).model_with_factors()


class _Resolver:
    def __init__(self, model: ir.Model, program: Program) -> None:
        self.model = model
        self.program = program
        self.touches = Touches(model)
        self.used: set[str] = set()

    def model_with_factors(self) -> ir.Model:
        model = self.model
        policy, kept = model.policy, model.history
        if policy is not None:
            lets = tuple(replace(x, dist=self._change(x.dist)) for x in policy.lets)
            policy = replace(policy, dist=self._change(policy.dist), lets=lets)
        registers = tuple(
            replace(r, update=replace(r.update, value=self._change(r.update.value))) for r in kept.registers
        )
        lower = None if model.lower is None else self._change(model.lower)
        beliefs = tuple(f.element for f in model.factors if f.element in self.used)
        kept = replace(kept, registers=registers, beliefs=beliefs)
        return replace(model, policy=policy, lower=lower, history=kept)

    def _change(self, node: Any) -> Any:
        if isinstance(node, ir.Clamp) and isinstance(node.operand, ir.BeliefRead):
            read = self._change(node.operand)
            return read if self._is_stored(read) else replace(node, operand=read)
        node = map_children(node, self._change)
        if not isinstance(node, ir.BeliefRead):
            return node
        try:
            return self._found(node)
        except Mistake as error:
            self.program.report.add(error)
            return node

    def _found(self, read: ir.BeliefRead) -> ir.BeliefRead:
        """Return the read with its factor and member."""
        asked = self.program.beliefs[read.number]
        found = leaves(self.touches.tree(read.operand))
        parts = list({p.key: p for leaf in found for p in leaf.parts if not p.draw}.values())
        if not parts:
            raise Mistake(e05_reads.belief_of_known(asked.function, asked.span))
        first, function, form = parts[0], asked.function, _form(asked.function)
        if first.vague:
            raise Mistake(e05_reads.belief_of_vague(function, first.read, first.vague, form, asked.span))
        if len(parts) > 1:
            other = next((p for p in parts if p.owner != first.owner), parts[1])
            if other.owner == first.owner:
                raise Mistake(e05_reads.belief_of_members(function, first.read, form, asked.span))
            raise Mistake(e05_reads.belief_of_elements(function, first.read, other.read, form, asked.span))
        self._require_kept(first.owner, asked.span)
        self.used.add(first.owner)
        return replace(read, element=first.owner, index=first.index)

    def _require_kept(self, element: str, span: Span) -> None:
        factor = next((f for f in self.model.factors if f.element == element), None)
        if factor is None:
            obstacle = next(o for o in self.model.obstacles if o.element == element)
            raise Mistake(e05_reads.belief_of_joint_state(element, obstacle.reason, span, obstacle.span))
        if factor.exact or factor.moments is not None:
            return
        why = factor.unmatched or factor.inexact
        drawn = next((x for x in self.model.lets if f"'{x.name}'" in why), None)
        if drawn is not None and drawn.draws:
            raise Mistake(e05_reads.inexact_belief_by_let(element, why, drawn.name, span, drawn.span))
        if factor.unmatched:
            raise Mistake(e05_reads.unmatched_belief(element, why, span))
        raise Mistake(e05_reads.inexact_belief(element, why, span))

    def _is_stored(self, read: ir.BeliefRead) -> bool:
        """Return whether the belief holds this very number, so that nothing is rounded."""
        return any(f.holds(read) for f in self.model.factors)
