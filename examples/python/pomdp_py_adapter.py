# SPDX-License-Identifier: Apache-2.0
"""A world and a planner of hypgen as those of pomdp_py: pip install pomdp_py."""

from pathlib import Path
from typing import Any

import pomdp_py

import hypgen


class Named(pomdp_py.Action, pomdp_py.Observation):
    """An action, or what was seen, which is equal where its value is."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Named) and self.value == other.value

    def __hash__(self) -> int:
        return hash(str(self.value))

    def __str__(self) -> str:
        return str(self.value)


class World(pomdp_py.Environment):
    """A simulated world; an agent does not see its state."""

    def __init__(self, worlds: hypgen.Worlds) -> None:
        super().__init__(pomdp_py.SimpleState("hidden"))
        self.worlds = worlds
        worlds.reset()

    def execute(self, action: Named, observation_model: Any = None) -> tuple[Named, float]:
        """Do an action; return what is seen and the reward."""
        self.worlds.step([self.worlds.action(action.value)])
        return Named(self.worlds.seen_by_name()), float(self.worlds.rewards[0])


class Planner(pomdp_py.Planner):
    """A planner that keeps the belief itself."""

    def __init__(self, planner: hypgen.Planner) -> None:
        self.planner = planner

    def plan(self, agent: pomdp_py.Agent) -> Named:
        """Decide by the planner's own belief."""
        return Named(self.planner.plan().name)

    def update(self, agent: pomdp_py.Agent, real_action: Named, real_observation: Named) -> None:
        """Take in what was done and seen."""
        self.planner.update(real_action.value, real_observation.value)

    def updates_agent_belief(self) -> bool:
        """Tell pomdp_py to leave the belief alone."""
        return True


def main() -> None:
    """Plan and act for an episode."""
    solver = hypgen.load(Path(__file__).parents[1] / "rock_sample.pomdp").compile()
    world = World(solver.worlds(seed=1))
    agent = pomdp_py.Agent(pomdp_py.Histogram({world.state: 1.0}))
    planner = Planner(solver.planner(mode="despot", trials=20, scenarios=50, seed=1, memory=64))
    planner.planner.reset(world.worlds.visible_by_name())
    earned = 0.0
    for step in range(60):
        action = planner.plan(agent)
        observation, reward = world.execute(action)
        earned += reward
        print(f"{step}: {action}, {observation}, {reward:g}")
        if world.worlds.terminal[0]:
            break
        agent.update_history(action, observation)
        planner.update(agent, action, observation)
    print(f"reward {earned:g}, steps in the agent's history: {len(agent.history)}")


if __name__ == "__main__":
    main()
