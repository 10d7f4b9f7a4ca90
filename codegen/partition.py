"""Updates -> stages -> element updates: the units that run independently of each other.

An element update is what one element writes in one stage, for all its members. Updates of a stage write
different variables and read next-state values of earlier stages only, so their order is free and different
threads may take them. What a filter takes from the observation key is a unit of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.codegen.guards import Guards, own_value
from hypgen.codegen.needs import NeedsAnalysis
from hypgen.dsl import ir
from hypgen.dsl.ir_walk import shape


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
    guards = Guards(model, NeedsAnalysis(model))
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
                    None if observed else guards.update(tuple(group)),
                )
                for (owner, observed), group in groups.items()
            )
        )
    return tuple(stages)


def _keeps(assign: ir.Assign) -> bool:
    return isinstance(assign.dist, ir.Certain) and shape(assign.dist.value) == shape(own_value(assign))
