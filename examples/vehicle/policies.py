# SPDX-License-Identifier: Apache-2.0
"""What sets the speed: the generated solver, and two rules to compare it with."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hypgen.api.solver import Solver
from vehicle import car
from vehicle.bridge import Bridge, Situation
from vehicle.crowd import RADIUS
from vehicle.scenes import Floats
from vehicle.tracks import Tracks

PULLS = {"maintain": 0.0, "accelerate": 0.8, "decelerate": -0.8, "brake": -2.5}  # m/s^2, by action
AIR = 0.2  # m beside and in front of people


@dataclass(frozen=True)
class Choice:
    """An acceleration in m/s^2, and how the decision came about."""

    pull: float
    status: str = ""
    trials: int = 0
    name: str = ""
    lower: float | None = None  # the bounds of the search
    upper: float | None = None


class Policy(Protocol):
    """Decides a drive's accelerations; ``tracks`` gives the tracks that it wants to be told of."""

    def tracks(self) -> Tracks:
        """Return tracks without anybody."""

    def decide(self, situation: Situation, deadline: float) -> Choice:
        """Choose until a time of ``time.monotonic``."""


class Planned:
    """A generated solver behind the bridge."""

    def __init__(self, bridge: Bridge) -> None:
        self.bridge = bridge
        bridge.planner.warm_up(0.05)

    def tracks(self) -> Tracks:
        """Return tracks that begin with the planner's belief."""
        return self.bridge.tracks()

    def decide(self, situation: Situation, deadline: float) -> Choice:
        """Plan until the deadline."""
        found = self.bridge.decide(situation, deadline)
        bounds = [None if math.isnan(b) else b for b in (found.lower, found.upper)]
        return Choice(PULLS[found.name], found.status, found.trials, found.name, *bounds)


class Reactive:
    """Brakes for whoever is on the way within the braking distance, and knows nothing of where people go."""

    def tracks(self) -> Tracks:
        """Return tracks without beliefs."""
        return Tracks(np.ones(1))

    def decide(self, situation: Situation, deadline: float) -> Choice:
        """Choose by where people are."""
        speed = situation.speed
        stop = speed**2 / (2 * 0.8) + 0.5 * speed + 0.5
        room = _room(situation, situation.tracks.at[situation.tracks.seen()], stop + 1.0)
        if room < 0.4 + speed**2 / (2 * 2.5) + 0.2 * speed:
            return Choice(PULLS["brake"] if speed > 0 else 0.0)
        return Choice(PULLS["decelerate" if room < stop else "accelerate"])


class TimeToCollision:
    """Takes the fastest action that keeps clear of people for some seconds, if all go on as they do now."""

    def tracks(self) -> Tracks:
        """Return tracks without beliefs."""
        return Tracks(np.ones(1))

    def decide(self, situation: Situation, deadline: float) -> Choice:
        """Try the actions from the fastest one on."""
        tracks, path = situation.tracks, situation.path
        seen = tracks.seen()
        at, velocity = tracks.at[seen], tracks.velocity[seen]
        times = np.arange(0.25, 4.01, 0.25)
        people = at[None] + velocity[None] * (times + situation.later)[:, None, None]
        for name in ("accelerate", "maintain", "decelerate"):
            first = np.minimum(times, 1.0)  # then it brakes gently
            speeds = np.clip(situation.speed + PULLS[name] * first, 0, car.TOP)
            speeds = np.clip(speeds - 0.8 * (times - first), 0, None)
            s = situation.s + np.cumsum(speeds) * 0.25
            if all(
                not _touches(path, where, now, speed)
                for where, now, speed in zip(s, people, speeds, strict=True)
            ):
                return Choice(PULLS[name])
        return Choice(PULLS["brake"] if situation.speed > 0 else 0.0)

    # A person who walks into a car that stands is no collision.


def _touches(path: object, s: float, people: Floats, speed: float) -> bool:
    if speed < 0.05 or not len(people):
        return False
    x, y = path.at(s)  # type: ignore[attr-defined]
    ahead = path.at(s + 1.0) - [x, y]  # type: ignore[attr-defined]
    ahead /= np.hypot(*ahead)
    rel = people - [x, y]
    along, aside = rel @ ahead, rel @ [-ahead[1], ahead[0]]
    wide = RADIUS + AIR
    return bool(
        ((along < car.FRONT + wide) & (along > -car.REAR - wide) & (abs(aside) < car.HALF + wide)).any()
    )


def _room(situation: Situation, people: Floats, most: float) -> float:
    """Return how far the car's front can go along the path before it meets somebody who stands still."""
    if not len(people):
        return most
    ahead = np.arange(0.0, most, 0.2)
    way = situation.path.at(situation.s + car.FRONT + ahead)
    apart = np.hypot(people[:, None, 0] - way[:, 0], people[:, None, 1] - way[:, 1]).min(0)
    close = np.flatnonzero(apart < car.HALF + RADIUS + AIR)
    return float(ahead[close[0]]) if len(close) else most


# The rows of the table: settings of the generated solver by name.
SOLVERS: dict[str, dict[str, str | int | bool]] = {
    "default": {"mode": "default"},
    "despot": {"mode": "despot", "scenarios": 100},
    "parallel": {"mode": "parallel", "scenarios": 500},
    "hyp": {"mode": "hyp", "scenarios": 1000, "require_gpu": True},
}
RULES: dict[str, Callable[[], Policy]] = {"reactive": Reactive, "ttc": TimeToCollision}


def make(name: str, solver: Solver | None, exits: Floats, period: float, seed: int) -> Policy:
    """Return a policy by its name in the table."""
    if name in RULES:
        return RULES[name]()
    if solver is None:
        raise ValueError(f"{name}: needs the model's library")
    planner = solver.planner(
        params={"first_dt": period},
        time=period,
        depth=20,
        memory=512,
        seed=seed,
        **SOLVERS[name],
    )
    return Planned(Bridge(planner, exits, period=period))


def now() -> float:
    """Return the clock of deadlines, s."""
    return time.monotonic()
