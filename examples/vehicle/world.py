# SPDX-License-Identifier: Apache-2.0
"""The world of a drive: car, crowd and sensor on one clock, and what is counted of a drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vehicle import car as cars
from vehicle.car import Car
from vehicle.crowd import RADIUS, Crowd
from vehicle.scenes import Floats, Scene
from vehicle.sensor import Scan, Sensor

TICK = 1 / 30  # s
HITS_AT, NEAR_AT = 0.1, 0.5  # m/s: a slower car hits nobody, and comes near nobody
FAST = 0.5  # m/s
NEAR = 0.25  # m
HARD = 1.5  # m/s^2: braking that throws who stands in the car
AGAIN = 3.0  # s: contact with one person counts once in this time


@dataclass
class Counts:
    """What is counted of a drive, in SI units."""

    seconds: float = 0.0
    metres: float = 0.0
    hits: int = 0  # people that the moving car touched
    front_hits: int = 0  # of these, with its front
    fast_hits: int = 0  # of these, at more than FAST
    near: int = 0  # people within NEAR of the moving car, not touched
    hard_brakings: int = 0
    nearest: float = 100.0  # m, of the moving car to a person


class World:
    """A scene that moves. ``pace`` multiplies the people's speeds, and ``noise`` the sensor's."""

    def __init__(self, scene: Scene, seed: int, *, pace: float = 1.0, noise: float = 1.0) -> None:
        random = np.random.default_rng([seed, 77])
        self.scene = scene
        self.crowd = Crowd(scene, np.random.default_rng([seed, 1]), pace=pace)
        self.car = Car(scene.start, np.random.default_rng([seed, 2]), TICK)
        self.sensor = Sensor(len(scene.people), random, noise=noise)
        self.counts = Counts()
        self._hit = np.full(len(scene.people), -np.inf)  # when each was touched last
        self._near = np.full(len(scene.people), -np.inf)
        self._brakes = self._odd = False

    def step(self) -> None:
        """Move the car by a tick, the people at every second one, and count."""
        pose = self.car.pose
        self._odd = not self._odd
        if self._odd:
            body = (cars.FRONT, cars.REAR, cars.HALF)
            self.crowd.step(2 * TICK, (pose.x, pose.y, pose.heading, pose.speed), body)
        self.car.step()
        self._count(np.hypot(self.car.pose.x - pose.x, self.car.pose.y - pose.y))

    def scan(self) -> Scan:
        """Return what the sensor detects now."""
        return self.sensor.scan(self.crowd.at, self.car.pose)

    def gaps(self) -> tuple[Floats, Floats]:
        """Return each person's distance to the car's body, below 0 in it, and their place along the car."""
        pose = self.car.pose
        rel = self.crowd.at - [pose.x, pose.y]
        ux, uy = np.cos(pose.heading), np.sin(pose.heading)
        along, aside = rel @ [ux, uy], rel @ [-uy, ux]
        dx = np.maximum(along - cars.FRONT, -cars.REAR - along)
        dy = np.abs(aside) - cars.HALF
        outside = np.hypot(np.maximum(dx, 0), np.maximum(dy, 0))
        return outside + np.minimum(np.maximum(dx, dy), 0) - RADIUS, along

    def _count(self, moved: float) -> None:
        counts, speed = self.counts, self.car.pose.speed
        counts.seconds += TICK
        counts.metres += float(moved)
        gaps, along = self.gaps()
        now = counts.seconds
        hit = (gaps < 0) & (speed > HITS_AT)
        new = hit & (now - self._hit > AGAIN)
        counts.hits += int(new.sum())
        front = int((new & (along > cars.FRONT - 0.3)).sum())
        counts.front_hits += front
        counts.fast_hits += front if speed > FAST else 0
        self._hit[hit] = now
        near = (gaps < NEAR) & (speed > NEAR_AT)
        counts.near += int((near & ~hit & (now - np.maximum(self._near, self._hit) > AGAIN)).sum())
        self._near[near] = now
        if speed > HITS_AT and len(gaps):
            counts.nearest = min(counts.nearest, float(gaps.min()))
        brakes = self.car.acceleration < -HARD and speed > 0.1
        counts.hard_brakings += int(brakes and not self._brakes)
        self._brakes = brakes

    def arrived(self) -> bool:
        """Whether the car is at its goal."""
        pose, goal = self.car.pose, self.scene.goal
        return bool(np.hypot(pose.x - goal[0], pose.y - goal[1]) < 1.2)
