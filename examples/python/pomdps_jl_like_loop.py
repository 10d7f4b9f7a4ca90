# SPDX-License-Identifier: Apache-2.0
"""The loops of a POMDPs.jl user: ``stepthrough`` of a planner, and simulations that compare policies."""

from pathlib import Path
from statistics import mean

import hypgen
from hypgen import EpisodeRecord, Observation, StepRecord

pomdp = hypgen.load(Path(__file__).parents[1] / "rock_sample.pomdp")
solver = pomdp.compile()


def heading_east(observation: Observation) -> str:
    """Leave by the east: a policy is any function from what is known to an action."""
    return "east"


# for (a, o, r) in stepthrough(pomdp, planner, "a,o,r", max_steps=10)
with solver.planner(mode="despot", trials=20, scenarios=50, seed=1, memory=64) as planner:
    for record in solver.simulate(planner, runs=1, steps=10):
        if isinstance(record, StepRecord):
            assert record.decision is not None
            bounds = f"{record.decision.lower:.1f} .. {record.decision.upper:.1f}"
            print(f"{record.step}: {record.name}, {record.seen}, {record.reward:g}, bounds {bounds}")

    # Both policies meet the same worlds: episode e of a seed is the same for each.
    for name, policy in (("planner", planner), ("heading east", heading_east)):
        records = solver.simulate(policy, runs=3, seed=1)
        returns = [r.discounted_return for r in records if isinstance(r, EpisodeRecord)]
        print(f"{name}: mean return {mean(returns):.2f} of {len(returns)} episodes")
