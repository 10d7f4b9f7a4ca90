# SPDX-License-Identifier: Apache-2.0
"""One drive: the loop of a robot, with a simulated world in place of the true one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import numpy as np

from vehicle import hybrid_a_star, policies, scenes
from vehicle.bridge import Situation
from vehicle.car import Pose
from vehicle.hybrid_a_star import Path
from vehicle.policies import Policy
from vehicle.tracks import Tracks
from vehicle.world import TICK, World

SCANS = 3  # ticks from scan to scan
LOOKS = 30  # ticks between looks whether the path is blocked
KEEPS = 0.02  # s that a decision leaves of its period


@dataclass
class Log:
    """What is noted of a drive's decisions."""

    seconds: list[float] = field(default_factory=list)  # each decision's update, search and glue
    statuses: dict[str, int] = field(default_factory=dict)
    trials: int = 0
    replans: int = 0


class Drive:
    """A drive through a scene. ``budget`` is the seconds of a decision; None: nearly all of the period.

    ``watch`` is told of each situation and choice.
    """

    def __init__(
        self,
        world: World,
        policy: Policy,
        hertz: float,
        budget: float | None = None,
        watch: Callable[[Drive, Situation, policies.Choice], None] | None = None,
    ) -> None:
        self.world, self.policy, self.log = world, policy, Log()
        self.ticks = round(1 / (hertz * TICK))
        self.period = self.ticks * TICK
        self._budget = self.period - KEEPS if budget is None else budget
        self._watch = watch
        self.tracks: Tracks = policy.tracks()
        path = hybrid_a_star.plan(world.scene, world.scene.start)
        if path is None:
            raise ValueError(f"{world.scene.name}: no path from start to goal")
        self.path: Path = path
        self.s = 0.0
        self._pull = self._next = 0.0

    def play(self, most_seconds: float) -> None:
        """Drive until the goal or the time is over."""
        world = self.world
        tick = 0
        while world.counts.seconds < most_seconds and not (world.arrived() and self.arrive()):
            pose = world.car.measured()
            self.s = self.path.project(pose.x, pose.y, self.s)
            if tick % SCANS == 0:
                self.tracks.step(world.scan(), SCANS * TICK)
            if tick % LOOKS == LOOKS - 1:
                self._look(pose)
            if tick % self.ticks == 0:
                self._pull = self._next  # what the last period was spent on begins now
                self._decide(pose)
            world.car.command(self._pull, hybrid_a_star.steer(self.path, pose, self.s))
            world.step()
            tick += 1

    def arrive(self) -> bool:
        """Return whether the drive is over now that the car is at its goal."""
        return True

    def _decide(self, pose: Pose) -> None:
        start = policies.now()
        later = self.period
        speed = float(np.clip(pose.speed + self._pull * later, 0, 2.0))
        situation = Situation(
            self.path, self.s + 0.5 * (pose.speed + speed) * later, speed, self.tracks, later
        )
        choice = self.policy.decide(situation, start + self._budget)
        self.log.seconds.append(policies.now() - start)
        self.log.statuses[choice.status] = self.log.statuses.get(choice.status, 0) + 1
        self.log.trials += choice.trials
        self._next = choice.pull
        if self._watch is not None:
            self._watch(self, situation, choice)

    def _look(self, pose: Pose) -> None:
        """Plan another path where people stand on this one."""
        tracks = self.tracks
        standing = tracks.at[tracks.seen() & (tracks.stood > 1.5)]
        if not len(standing):
            return
        way = self.path.at(self.s + 2.2 + np.arange(0.0, 8.0, 0.25))
        apart = np.hypot(standing[:, None, 0] - way[:, 0], standing[:, None, 1] - way[:, 1])
        if apart.min() > 1.0:
            return
        start = (pose.x, pose.y, pose.heading)
        path = hybrid_a_star.plan(self.world.scene, start, standing, free=2.5)
        self.log.replans += 1
        if path is not None:
            self.path, self.s = path, 0.0


def summary(drive: Drive) -> dict[str, object]:
    """Return a drive as a line of results."""
    log, tracks, seconds = drive.log, drive.tracks, np.array(drive.log.seconds)
    bridge = getattr(drive.policy, "bridge", None)
    return {
        **asdict(drive.world.counts),
        "arrived": drive.world.arrived(),
        "decisions": len(seconds),
        "late": int((seconds > drive.period + 0.001).sum()),
        "latest": float(seconds.max() - drive.period),
        "decision_p99": float(np.percentile(seconds, 99)),
        "trials": log.trials / max(1, len(seconds)),
        "statuses": log.statuses,
        "replans": log.replans,
        "found_again": tracks.found_again,
        "surprise": tracks.surprise,
        "odd_updates": bridge.odd_updates if bridge is not None else 0,
    }


def scene_of(name: str, seed: int, people: int) -> scenes.Scene:
    """Return a scene; its people are placed by the seed."""
    return scenes.make(name, seed, people)
