"""``belief(e)``: the mean of ``e`` given what the agent has seen, from a factor's exact posterior."""

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
from hypgen.dsl.messages.report import Mistake, mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Bool, Float

_FORM = "belief(e), where e reads hidden variables of one element, or of one member of a family"


def belief(node: ast.Call, scope: Scope) -> ir.Expr:
    """Return the read of a posterior; whose it is follows when the whole model is known (``resolved``)."""
    if len(node.arguments) != 1:
        message = f"'belief' takes 1 argument, here {len(node.arguments)}"
        raise mistake("E0302", message, node.span, f"its form is {_FORM}")
    if not scope.history:
        raise mistake(
            "E0505",
            "'belief' is known to the policy only",
            node.span,
            "use it in the policy or in 'bound lower'; a fn can be given its value",
        )
    if scope.primed:
        raise mistake("E0407", "a belief has no next value", node.span, "remove the prime")
    number = len(scope.program.beliefs)
    asked = Asked(node.span, Owner("belief", str(number), scope.owner))
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
        message = f"belief(..) is a mean, of a bool or a number, but this is {operand.type}"
        raise mistake("E0301", message, node.arguments[0].span, "ask for a condition: belief(x == value)")
    read = ir.BeliefRead(mean, number, "", None, operand)
    if math.isinf(mean.low) or math.isinf(mean.high):
        return read
    return ir.Clamp(mean, read, mean.low, mean.high)  # a mean may be rounded to beyond the ends


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
            remedy = "its value is known: write it without belief(..)"
            raise mistake("E0506", "belief(..) of something that reads nothing hidden", asked.span, remedy)
        first = parts[0]
        if first.vague or len(parts) > 1:
            message = f"belief(..) reads '{first.read}' {first.vague}"
            if not first.vague:
                other = next((p for p in parts if p.owner != first.owner), parts[1])
                several = f"'{first.read}' and '{other.read}', hidden state of two elements"
                message = f"belief(..) reads {several}"
                if other.owner == first.owner:
                    message = f"belief(..) reads '{first.read}' of several members of the family"
            remedy = f"ask for one at a time: {_FORM}"
            raise mistake("E0506", message, asked.span, remedy)
        self._require_exact(first.owner, asked.span)
        self.used.add(first.owner)
        return replace(read, element=first.owner, index=first.index)

    def _require_exact(self, element: str, span: Span) -> None:
        factor = next((f for f in self.model.factors if f.element == element), None)
        if factor is not None and factor.exact:
            return
        notes: list[tuple[Span, str]] = []
        if factor is not None:
            message = f"there is no exact belief about '{element}': {factor.inexact}"
        else:
            obstacle = next(o for o in self.model.obstacles if o.element == element)
            message = f"there is no belief about '{element}' alone: {obstacle.reason}"
            notes = [(obstacle.span, "it is read here")]
        remedy = (
            "keep what was seen in the policy's memory: memory m: T = first   m' = .. last(reading, first) .."
        )
        drawn = (
            None if factor is None else next((x for x in self.model.lets if f"'{x.name}'" in message), None)
        )
        if drawn is not None and drawn.draws:
            notes = [(drawn.span, f"'{drawn.name}' is drawn here")]
            remedy = f"draw in the update itself, x' ~ .., in place of the let; or {remedy}"
        raise mistake("E0506", message, span, remedy, notes)

    def _is_stored(self, read: ir.BeliefRead) -> bool:
        """Return whether the mean is a probability that the posterior holds, so that nothing is rounded."""
        return any(f.holds(read) for f in self.model.factors)
