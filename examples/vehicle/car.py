# SPDX-License-Identifier: Apache-2.0
"""A car of its own kinematics: a bicycle with delay, lag, limits and noise."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

FRONT, REAR, HALF = 1.9, 0.5, 0.6  # m, of the body, from the rear axle
BASE = 1.4  # m, between the axles
TURN = 3.5  # m, the least radius
TOP = 2.0  # m/s
DELAY = 0.1  # s, until a command arrives
LAG = 0.15  # s, of the drive
STEER_RATE = 0.8  # rad/s
ACCELERATION_SD = 0.05  # m/s^2
STEER_SD = 0.01  # rad
PLACE_SD, SPEED_SD = 0.03, 0.02  # m and m/s: of what the car measures of itself


@dataclass(frozen=True)
class Pose:
    """The rear axle's place, the heading, and the speed."""

    x: float
    y: float
    heading: float
    speed: float


class Car:
    """The true car. ``command`` sets what it is asked for, and ``step`` moves it."""

    def __init__(self, start: tuple[float, float, float], random: np.random.Generator, tick: float) -> None:
        self.pose = Pose(*start, 0.0)
        self._random, self._tick = random, tick
        self._pending = deque([(0.0, 0.0)] * max(1, round(DELAY / tick)))
        self.acceleration = self._steer = 0.0

    def command(self, acceleration: float, steer: float) -> None:
        """Ask for an acceleration in m/s^2 and a steering angle in rad, from the next tick on."""
        self._pending.append((acceleration, steer))

    def step(self) -> None:
        """Move by a tick; a tick without a command repeats the last one."""
        if len(self._pending) <= max(1, round(DELAY / self._tick)):
            self._pending.append(self._pending[-1])
        asked, steer = self._pending.popleft()
        tick, pose = self._tick, self.pose
        self.acceleration += (asked - self.acceleration) * min(1.0, tick / LAG)
        noise = self._random.normal(0, 1, 2) * np.sqrt(tick / 0.1)
        steepest = np.arctan(BASE / TURN) * 1.1
        turned = np.clip(steer - self._steer, -STEER_RATE * tick, STEER_RATE * tick)
        self._steer = float(np.clip(self._steer + turned, -steepest, steepest))
        push = self.acceleration + (noise[0] * ACCELERATION_SD if pose.speed > 0 else 0)
        speed = float(np.clip(pose.speed + push * tick, 0.0, TOP * 1.05))
        angle = self._steer + noise[1] * STEER_SD
        mean = 0.5 * (pose.speed + speed)
        self.pose = Pose(
            pose.x + mean * np.cos(pose.heading) * tick,
            pose.y + mean * np.sin(pose.heading) * tick,
            pose.heading + mean * np.tan(angle) / BASE * tick,
            speed,
        )

    def measured(self) -> Pose:
        """Return what the car measures of itself."""
        noise = self._random.normal(0, 1, 4) * [PLACE_SD, PLACE_SD, 0.005, SPEED_SD]
        p = self.pose
        return Pose(p.x + noise[0], p.y + noise[1], p.heading + noise[2], max(0.0, p.speed + noise[3]))
