# SPDX-License-Identifier: Apache-2.0
"""Episodes of a planner, or of any policy, in a simulated world."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from hypgen.api.c_interface import PlannerError
from hypgen.api.planner import Decision, Planner
from hypgen.api.worlds import Worlds

DEFAULT_STEPS = 90  # as of a solver's --steps


@dataclass(frozen=True)
class Observation:
    """What is known before a step: values by name, and the numbers of the legal actions.

    ``seen`` is empty before the first step.
    """

    episode: int
    step: int
    visible: dict[str, Any]
    seen: dict[str, Any]
    legal: tuple[int, ...]


@dataclass(frozen=True)
class StepRecord:
    """A step: what was done, earned and seen.

    ``visible`` has the variables after the step. ``seen`` is empty after a terminal step. ``decision`` and
    ``belief_status`` are those of a planner; a policy has none.
    """

    episode: int
    step: int
    action: int
    name: str
    reward: float
    seen: dict[str, Any]
    visible: dict[str, Any]
    terminal: bool
    decision: Decision | None = None
    belief_status: str | None = None


@dataclass(frozen=True)
class EpisodeRecord:
    """How an episode went; ``status`` is ``terminal``, ``step_limit`` or ``no_legal_action``."""

    episode: int
    discounted_return: float
    undiscounted_return: float
    steps: int
    terminal: bool
    success: bool
    status: str


Policy = Callable[[Observation], int | str]


def simulate(
    worlds: Worlds, planner: Planner | Policy, episodes: range, steps: int | None
) -> Iterator[StepRecord | EpisodeRecord]:
    """Return the steps of each episode, and after them the episode, as the solver's command line plays it.

    A planner of another interface is refused at once; the world is closed at the end.
    """
    ours = (worlds.actions, worlds.visible_fields, worlds.seen_fields)
    if (
        isinstance(planner, Planner)
        and (planner.actions, planner.visible_fields, planner.seen_fields) != ours
    ):
        worlds.close()
        text = "planner: its model has other actions, visible variables or observations than the world's"
        raise PlannerError("wrong_argument", text)
    return _episodes(worlds, planner, episodes, steps)


def _episodes(
    worlds: Worlds, planner: Planner | Policy, episodes: range, steps: int | None
) -> Iterator[StepRecord | EpisodeRecord]:
    limit = min(DEFAULT_STEPS if steps is None else steps, worlds.horizon or 2**31)
    with worlds:
        for episode in episodes:
            yield from _play(worlds, planner, episode, limit)


def _play(
    worlds: Worlds, planner: Planner | Policy, episode: int, limit: int
) -> Iterator[StepRecord | EpisodeRecord]:
    worlds.reset([episode])
    if isinstance(planner, Planner):
        planner.reset(worlds.visible[0].tolist(), episode=episode)
    discounted, undiscounted, weight = 0.0, 0.0, 1.0
    done, success, status = 0, False, "step_limit"
    while done < limit:
        if not worlds.legal.any():
            status = "no_legal_action"
            break
        action, decision = _decide(planner, worlds, episode, done)
        worlds.step([action])
        terminal = bool(worlds.terminal[0])
        belief_status = None
        if isinstance(planner, Planner) and not terminal:
            belief_status = planner.update(action, worlds.keys[0].tolist())
        reward = float(worlds.rewards[0])
        discounted += weight * reward
        undiscounted += reward
        success = success or bool(worlds.success[0])
        yield StepRecord(
            episode,
            done,
            action,
            worlds.actions[action],
            reward,
            {} if terminal else worlds.seen_by_name(),
            worlds.visible_by_name(),
            terminal,
            decision,
            belief_status,
        )
        done += 1
        weight *= worlds.discount
        if terminal:
            status = "terminal"
            break
    yield EpisodeRecord(episode, discounted, undiscounted, done, status == "terminal", success, status)


def _decide(
    planner: Planner | Policy, worlds: Worlds, episode: int, step: int
) -> tuple[int, Decision | None]:
    if isinstance(planner, Planner):
        decision = planner.plan()
        return decision.action, decision
    return worlds.action(planner(_observation(worlds, episode, step))), None


def _observation(worlds: Worlds, episode: int, step: int) -> Observation:
    return Observation(
        episode,
        step,
        worlds.visible_by_name(),
        worlds.seen_by_name() if step > 0 else {},
        tuple(worlds.legal[0].nonzero()[0].tolist()),
    )
