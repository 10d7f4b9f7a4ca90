"""Updates -> stages -> element updates: the units that run independently of each other.

An element update is what one element writes in one stage, for all its members. Updates of a stage write
different variables and read next-state values of earlier stages only, so their order is free and different
threads may take them. What a filter takes from the observation key is a unit of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.codegen.needs import NeedsAnalysis
from hypgen.codegen.walk import free_locals, shape, walk
from hypgen.dsl import ir
from hypgen.dsl.types import BOOL


@dataclass(frozen=True)
class ElementUpdate:
    """What an element (each member of a family) writes in a stage.

    ``observed``: the variables come with the observation key, so the filter does not draw them. ``guard``:
    where it is false nothing changes, for any member.
    """

    element: ir.Element
    stage: int
    observed: bool
    assigns: tuple[ir.Assign, ...]
    guard: ir.Expr | None


def partition(model: ir.Model) -> tuple[tuple[ElementUpdate, ...], ...]:
    """Return the element updates, stage by stage. Variables that keep their value need none."""
    visible = {v.name for v in model.variables if v.visible and not v.determined}
    stages = []
    for assigns in model.stages():
        groups: dict[tuple[str, bool], list[ir.Assign]] = {}
        for assign in assigns:
            if not _keeps(assign) or assign.variable in visible:
                owner = model.variable(assign.variable).element
                groups.setdefault((owner, assign.variable in visible), []).append(assign)
        stages.append(
            tuple(
                ElementUpdate(
                    next(e for e in model.elements if e.name == owner),
                    assigns[0].stage,
                    observed,
                    tuple(group),
                    None if observed else _guard(group, NeedsAnalysis(model)),
                )
                for (owner, observed), group in groups.items()
            )
        )
    return tuple(stages)


def reward_guard(reward: ir.Reward, needs: NeedsAnalysis) -> ir.Expr | None:
    """Return a condition that is the same for all members and without which the term is 0."""
    return _cheap(_zero_unless(reward.value), set() if reward.binder is None else {reward.binder.name}, needs)


def _keeps(assign: ir.Assign) -> bool:
    return isinstance(assign.dist, ir.Certain) and shape(assign.dist.value) == _own(assign)


def _own(assign: ir.Assign) -> object:
    indices = tuple(ir.Local(b.type, b.name) for b in assign.binders)
    return shape(ir.StateRead(BOOL, assign.variable, indices))


def _guard(assigns: list[ir.Assign], needs: NeedsAnalysis) -> ir.Expr | None:
    """Return the condition that all assigns share and that does not depend on the member."""
    guards = []
    for assign in assigns:
        conditions = _changes_only_if(assign.dist, _own(assign))
        guards.append(_cheap(conditions, {b.name for b in assign.binders}, needs))
    first = guards[0]
    return first if first is not None and all(shape(g) == shape(first) for g in guards) else None


def _changes_only_if(node: ir.Expr | ir.Dist, own: object) -> list[ir.Expr]:
    """Return conditions that all hold where the value differs from the variable's own."""
    match node:
        case ir.Certain(value=value):
            return _changes_only_if(value, own)
        case ir.Binary(op="and", left=left, right=right) if shape(left) == own:
            return _conjuncts(_negated(right))
        case (
            ir.If(condition=condition, then=then, otherwise=otherwise)
            | ir.IfDist(condition=condition, then=then, otherwise=otherwise)
        ):
            if _is_own(otherwise, own):
                return _conjuncts(condition) + _changes_only_if(then, own)
            if _is_own(then, own):
                return _conjuncts(_negated(condition)) + _changes_only_if(otherwise, own)
    return []


def _is_own(node: ir.Expr | ir.Dist, own: object) -> bool:
    return shape(node.value if isinstance(node, ir.Certain) else node) == own


def _zero_unless(value: ir.Expr) -> list[ir.Expr]:
    match value:
        case ir.If(condition=condition, then=then, otherwise=ir.Const(value=zero)) if zero == 0:
            return _conjuncts(condition) + _zero_unless(then)
        case ir.If(condition=condition, then=ir.Const(value=zero), otherwise=otherwise) if zero == 0:
            return _conjuncts(_negated(condition)) + _zero_unless(otherwise)
    return []


def _conjuncts(expr: ir.Expr) -> list[ir.Expr]:
    if isinstance(expr, ir.Binary) and expr.op == "and":
        return _conjuncts(expr.left) + _conjuncts(expr.right)
    return [expr]


def _negated(expr: ir.Expr) -> ir.Expr:
    if isinstance(expr, ir.Unary) and expr.op == "not":
        return expr.operand
    return ir.Unary(BOOL, "not", expr)


def _cheap(conditions: list[ir.Expr], members: set[str], needs: NeedsAnalysis) -> ir.Expr | None:
    """Return the conjunction of those conditions that are plain tests and depend on no member."""
    if not members:
        return None  # nothing to hoist out of: there is one member
    chosen = None
    for condition in conditions:
        plain = not any(
            isinstance(n, ir.Call | ir.LetRead | ir.Quantified | ir.LetIn) for n in walk(condition)
        )
        if plain and not free_locals(condition) and "draws" not in needs.of(condition):
            chosen = condition if chosen is None else ir.Binary(BOOL, "and", chosen, condition)
    return chosen
