# SPDX-License-Identifier: Apache-2.0
"""Densities of what is seen as tables, filled once when params are loaded.

To weigh a value by a law of a float that is cut into bins, or by a law of counts, takes many times as long as
a load. A belief does so for each of its values, and a policy that reads a belief does so in each step of a
rollout. The entries come from the law itself, so results are the same bit for bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hypgen.codegen.layout import limits
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.dsl import ir
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.types import is_finite, size_of


@dataclass(frozen=True)
class DensityTable:
    """The densities of an observation, by its value, its binders and the variables that its law reads.

    ``name`` is its C++ name in ``Params``. A binder stands for each variable, which is read after the step.
    """

    name: str
    observation: ir.Observation
    value: ir.Binder
    variables: tuple[str, ...]
    reads: tuple[ir.Binder, ...]

    @property
    def inputs(self) -> tuple[ir.Binder, ...]:
        """Return what an entry is found by: what a belief goes through lies side by side."""
        return (self.value, *self.observation.binders, *self.reads)


def density_tables(model: ir.Model, needs: NeedsAnalysis, names: Names) -> dict[ir.Dist, DensityTable]:
    """Return a table for each distribution of an observation that takes long and has few inputs."""
    found: dict[ir.Dist, DensityTable] = {}
    for observation in model.observations:
        table = _table(observation, model, needs)
        if table is not None and observation.dist not in found:
            name = names.derived_table(f"density_{observation.name}_table")
            found[observation.dist] = DensityTable(name, observation, *table)
    return found


def _table(
    observation: ir.Observation, model: ir.Model, needs: NeedsAnalysis
) -> tuple[ir.Binder, tuple[str, ...], tuple[ir.Binder, ...]] | None:
    functions = {f.name: f for f in model.functions}
    lets = {let.name: let for let in model.all_lets}
    nodes = [node for node, _ in reached((observation.dist,), functions, lets)]
    if not any(isinstance(node, ir.Binned | ir.Counted) for node in nodes):
        return None
    if not needs.of_density(observation.dist) <= {"params", "next"}:
        return None
    read = dict.fromkeys(node.variable for node in nodes if isinstance(node, ir.StateRead))
    variables = [model.variable(name) for name in read]
    value = ir.Binder("seen%density", observation.type)
    reads = tuple(ir.Binder(f"{v.name}%density", v.type) for v in variables)
    types = [b.type for b in (value, *observation.binders, *reads)]
    if any(v.indices for v in variables) or not all(map(is_finite, types)):
        return None
    return (value, tuple(read), reads) if math.prod(map(size_of, types)) <= limits.MAX_TABLE_ENTRIES else None
