# SPDX-License-Identifier: Apache-2.0
"""Conditions without which an update changes nothing, or a reward term is zero.

``good' = good and not (act == sample and here(r))`` changes only where ``act == sample``, for any member: the
loop over r runs only then. In rollouts the action is often a constant, and the loop disappears.

``food' = [y in Y: food[y] and not y == pac.y']`` changes one entry: there is no loop over y.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.hoisting import Hoisting
from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.inline import Inliner
from hypgen.dsl.ir.walk import Kind, free_locals, map_children, negated, shape, walk
from hypgen.dsl.types import BOOL, Int, Type, size_of

# A guard that loops longer than this is not cheaper than what it guards.
_MAX_LOOP = 8

# Binders of an array's entries, each with its value.
Index = tuple[tuple[str, ir.Expr], ...]


class Guards:
    """Finds the guards of one model."""

    def __init__(self, model: ir.Model, needs: NeedsAnalysis) -> None:
        self.inliner = Inliner({f.name: f for f in model.functions}, {})
        self.hoisting = Hoisting(model)
        self.needs = needs

    def update(self, assigns: tuple[ir.Assign, ...]) -> ir.Expr | None:
        """Return the guard that all assigns of an element update share."""
        guards = [
            self._weakest(changes_only_if(a.dist, shape(own_value(a))), len(a.binders)) for a in assigns
        ]
        first = guards[0]
        return first if first is not None and all(shape(g) == shape(first) for g in guards) else None

    def index(self, assign: ir.Assign, binders: Sequence[ir.Binder]) -> Index:
        """Return the index of the only entries of an array that may change, as far as it is known."""
        kinds = {b.name: b.type for b in binders}
        found: dict[str, ir.Expr] = {}
        for condition in _conjuncts(changes_only_if(assign.dist, shape(own_value(assign)))):
            if not isinstance(condition, ir.Binary) or condition.op != "eq":
                continue
            for local, value in ((condition.left, condition.right), (condition.right, condition.left)):
                if (
                    isinstance(local, ir.Local)
                    and local.name in kinds
                    and not free_locals(value) & kinds.keys()
                    and _lies_in(value.type, kinds[local.name])
                    and self.hoisting.is_safe(value)
                ):
                    found.setdefault(local.name, value)
        return tuple(found.items())

    def reward(self, term: ir.Reward) -> ir.Expr | None:
        """Return the guard of a reward term."""
        return self._weakest(zero_unless(term.value), 0 if term.binder is None else 1)

    def _weakest(self, conditions: list[ir.Expr], loops: int) -> ir.Expr | None:
        """Return what the conditions imply for every member alike; None where there is no loop to save."""
        if not loops:
            return None
        return _conjunction([self._weaken(c, frozenset()) for c in conditions])

    def _weaken(self, condition: ir.Expr, bound: frozenset[str]) -> ir.Expr | None:
        """Return a cheap condition that ``condition`` implies and that reads no locals but ``bound``."""
        match condition:
            case ir.Binary(op="and", left=left, right=right):
                return _conjunction([self._weaken(left, bound), self._weaken(right, bound)])
            case ir.Call():
                return self._weaken(self.inliner.call(condition), bound)
            case ir.Quantified(kind="any", binders=binders, condition=where, body=body) if (
                math.prod(size_of(b.type) for b in binders) <= _MAX_LOOP
            ):
                inner = bound | {b.name for b in binders}
                parts = [self._weaken(part, inner) for part in (where, body) if part is not None]
                found = _conjunction(parts)
                return None if found is None else ir.Quantified(BOOL, "any", binders, None, found, None)
        costly = ir.Call | ir.LetRead | ir.LetIn | ir.Quantified
        plain = not any(isinstance(node, costly) for node in walk(condition))
        if plain and free_locals(condition) <= bound and "draws" not in self.needs.of(condition):
            return condition
        return None


def own_value(assign: ir.Assign) -> ir.StateRead:
    """Return the read of the value that the variable has before the step."""
    return ir.StateRead(BOOL, assign.variable, tuple(ir.Local(b.type, b.name) for b in assign.binders))


def changes_only_if(node: ir.Expr | ir.Dist, own: object) -> list[ir.Expr]:
    """Return conditions that all hold where the value differs from the variable's own."""
    match node:
        case ir.Certain(value=value):
            return changes_only_if(value, own)
        case ir.Binary(op="and", left=left, right=right) if shape(left) == own:
            return [negated(right)]
        case ir.Binary(op="or", left=left, right=right) if shape(left) == own:
            return [right]
        case (
            ir.If(condition=condition, then=then, otherwise=otherwise)
            | ir.IfDist(condition=condition, then=then, otherwise=otherwise)
        ):
            if _is_own(otherwise, own):
                return [condition, *changes_only_if(then, own)]
            if _is_own(then, own):
                return [negated(condition), *changes_only_if(otherwise, own)]
    return []


def at_index(node: Kind, index: Index) -> Kind:
    """Return what is left of ``node`` where binders have the values of ``index``: no local hides another."""
    values = dict(index)

    def change(node: Any) -> Any:
        if isinstance(node, ir.Binary) and node.op == "eq":
            for local, value in ((node.left, node.right), (node.right, node.left)):
                if isinstance(local, ir.Local) and shape(values.get(local.name)) == shape(value):
                    return operators.boolean(True)
        match map_children(node, change):
            case ir.Binary(op="and", left=left, right=right):
                return operators.both(left, right)
            case ir.Binary(op="or", left=left, right=right):
                return operators.either(left, right)
            case ir.Unary(op="not", operand=operand):
                return operators.invert(operand)
            case ir.If(condition=condition, then=then, otherwise=otherwise):
                return operators.choose(condition, then, otherwise)
            case changed:
                return changed

    found: Kind = change(node) if index else node
    return found


def zero_unless(value: ir.Expr) -> list[ir.Expr]:
    """Return conditions that all hold where the value is not zero."""
    match value:
        case ir.If(condition=condition, then=then, otherwise=ir.Const(value=zero)) if zero == 0:
            return [condition, *zero_unless(then)]
        case ir.If(condition=condition, then=ir.Const(value=zero), otherwise=otherwise) if zero == 0:
            return [negated(condition), *zero_unless(otherwise)]
        case ir.Quantified(kind="sum", binders=binders, condition=ir.Expr() as condition):
            return [ir.Quantified(BOOL, "any", binders, None, condition, None)]
    return []


def _conjuncts(conditions: Sequence[ir.Expr]) -> list[ir.Expr]:
    found = list[ir.Expr]()
    for condition in conditions:
        match condition:
            case ir.Binary(op="and", left=left, right=right):
                found += _conjuncts((left, right))
            case _:
                found.append(condition)
    return found


def _lies_in(t: Type, whole: Type) -> bool:
    if isinstance(t, Int) and isinstance(whole, Int):
        return whole.low <= t.low and t.high <= whole.high
    return t == whole


def _is_own(node: ir.Expr | ir.Dist, own: object) -> bool:
    return bool(shape(node.value if isinstance(node, ir.Certain) else node) == own)


def _conjunction(parts: list[ir.Expr | None]) -> ir.Expr | None:
    result = None
    for part in parts:
        if part is not None:
            result = part if result is None else ir.Binary(BOOL, "and", result, part)
    return result
