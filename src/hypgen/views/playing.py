# SPDX-License-Identifier: Apache-2.0
"""Plays an episode with a model's planner, and keeps all that a page shows of it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hypgen.api.c_interface import PlannerError
from hypgen.api.model import Model
from hypgen.api.planner import Moments, Planner
from hypgen.api.programs import Progress
from hypgen.api.simulation import DEFAULT_STEPS
from hypgen.dsl import ir
from hypgen.dsl.interpret.episode import Episode, Values
from hypgen.dsl.interpret.value_text import action_text, value_text
from hypgen.dsl.types import Bool, Float, Int, Type

_LEVELS, _TOP = 5, 12  # of a tree, before it is cut
_MARGINALS, _LIKELIEST = 400, 5


@dataclass(frozen=True)
class Played:
    """An episode: header, steps, and what is true after the last one."""

    header: dict[str, Any]
    steps: list[dict[str, Any]]
    end: dict[str, Any]


def play(
    model: Model,
    options: Mapping[str, Any],
    *,
    episode: int = 0,
    steps: int | None = None,
    progress: Progress | None = None,
) -> Played:
    """Play an episode of a model, with options of its solver, in the world of the solver's run ``episode``.

    It ends after ``steps``, which are those of the model's horizon, or else 90. ``progress`` is told of what
    is built. A wrong option raises ``PlannerError``.
    """
    solver = model.compile(target="cpu", progress=progress)
    checked = model.loaded.model
    with solver.planner(**options) as planner, solver.worlds(1, seed=planner.info["seed"]) as worlds:
        worlds.reset([episode])
        planner.reset(worlds.visible[0].tolist(), episode=episode)
        world = Episode(checked, planner.info["seed"], episode)
        limit = min(steps or checked.horizon or DEFAULT_STEPS, checked.horizon or math.inf)
        played: list[dict[str, Any]] = []
        update_seconds = None  # of what the step before has shown
        while len(played) < limit and not world.now.terminal and world.legal():
            step, number = _plan(planner, world)
            outcome = world.step(number)
            worlds.step([number])
            seen = {} if world.now.terminal else worlds.seen_by_name()
            played.append(
                step
                | {
                    "update_seconds": update_seconds,
                    "reward": outcome.reward,
                    "terms": outcome.terms,
                    "seen": seen,
                }
            )
            if not world.now.terminal:
                began = time.perf_counter()
                planner.update(number, worlds.keys[0].tolist())
                update_seconds = time.perf_counter() - began
        header = {
            "ended": _ending(world),
            "name": checked.name,
            "hash": checked.source_hash,
            "file": model.origin.rpartition("/")[2],
            "discount": checked.discount,
            "episode": episode,
            "options": dict(options),
        }
        return Played(header, played, {"state": _state(world)})


def _plan(planner: Planner, world: Episode) -> tuple[dict[str, Any], int]:
    """Return what is known before a step, and the number of the action."""
    marginals = [
        {"variable": name, "mean": one.mean, "deviation": one.deviation}
        if isinstance(one, Moments)
        else {
            "variable": name,
            "values": [
                {"value": value, "probability": p}
                for value, p in sorted(one.items(), key=lambda item: -item[1])[:_LIKELIEST]
            ],
        }
        for name, one in list(planner.belief.items())[:_MARGINALS]
    ]
    units = [unit["effective"] for unit in planner.info.get("units", ()) if unit.get("effective") is not None]
    state = _state(world)
    default = action_text(world.policy_action(), world.model.action)
    decision = planner.plan()
    step = {
        "step": world.now.time,
        "action": decision.name,
        "default_action": default,
        "state": state,
        "marginals": marginals,
        "status": decision.status,
        "lower": decision.lower,
        "upper": decision.upper,
        "search_seconds": decision.seconds,
        "trials": decision.trials,
        "expansions": decision.expansions,
        "scenarios": decision.scenarios,
        "max_depth": decision.max_depth,
        "effective_sample_size": min(units, default=None),
        "tree": _tree(planner),
    }
    return step, decision.action


def _tree(planner: Planner) -> dict[str, Any] | None:
    """Return the tree that the last plan decided by, None where it searched none."""
    try:
        return planner.tree(depth=_LEVELS, top=_TOP)
    except PlannerError:  # it decided by other means
        return None


def _ending(world: Episode) -> str:
    if world.now.terminal:
        return "terminal"
    return "horizon" if world.now.time == world.model.horizon else "step_limit"


def _state(world: Episode) -> dict[str, Any]:
    values: Values = world.values()
    return {v.name: _plain(values[v.name], v) for v in world.model.variables}


def _plain(values: list[Any], variable: ir.Variable) -> Any:
    found = [_value(value, variable.type) for value in values]
    return found if variable.indices else found[0]


def _value(value: Any, t: Type) -> Any:
    if isinstance(t, Bool | Int):
        return value
    if isinstance(t, Float):
        return value if math.isfinite(value) else None
    return value_text(value, t)
