# SPDX-License-Identifier: Apache-2.0
"""People who walk by social forces (Helbing and Molnar, 1995), and avoid the car if they attend to it."""

from __future__ import annotations

import numpy as np

from vehicle.scenes import WALKS, Floats, Scene

RADIUS = 0.25  # m, of a person
RELAXES = 0.5  # s, until a wanted velocity is reached
REPELS, REACH = 3.0, 0.35  # m/s^2 and m: the force between people who touch, and how fast it falls off
BEHIND = 0.3  # how much of the force one feels from who is behind
CHANGES = 0.02  # per second: another exit, or a stop
STOPS = 0.3  # of the changes


class Crowd:
    """All people of a scene, in arrays by person: ``at`` and ``velocity`` are (people, 2)."""

    def __init__(self, scene: Scene, random: np.random.Generator, *, pace: float = 1.0) -> None:
        count = len(scene.people)
        self.scene, self._random = scene, random
        self.at = scene.people.copy()
        self.aims = scene.aims.copy()
        self.velocity = np.zeros((count, 2))
        self.wanted = np.clip(random.normal(WALKS, 0.2, count), 0.6, 1.8) * pace
        self.attends = random.random(count) < 0.7  # to the car

    def step(self, seconds: float, car: tuple[float, float, float, float], body: tuple[float, ...]) -> None:
        """Move everybody on. ``car`` is x, y, heading and speed; ``body`` its front, rear and half width."""
        self._change_aims(seconds)
        towards = self.scene.exits[np.maximum(self.aims, 0)] - self.at
        towards /= np.maximum(np.hypot(*towards.T), 0.1)[:, None]
        wanted = np.where((self.aims >= 0)[:, None], towards * self.wanted[:, None], 0.0)
        force = (wanted - self.velocity) / RELAXES
        force += self._from_people() + self._from_walls() + self._from_car(car, body)
        self.velocity += force * seconds
        speed = np.hypot(*self.velocity.T)
        self.velocity *= np.minimum(1.0, 1.3 * self.wanted / np.maximum(speed, 1e-6))[:, None]
        self.at += self.velocity * seconds
        self.at = np.clip(self.at, 0.2, [self.scene.width - 0.2, self.scene.height - 0.2])

    def _change_aims(self, seconds: float) -> None:
        there = np.hypot(*(self.scene.exits[np.maximum(self.aims, 0)] - self.at).T) < 1.5
        changes = self._random.random(len(self.aims)) < CHANGES * seconds
        for i in np.flatnonzero(changes | (there & (self.aims >= 0))):
            others = [e for e in range(len(self.scene.exits)) if e != self.aims[i]]
            stops = changes[i] and self._random.random() < STOPS
            self.aims[i] = -1 if stops else self._random.choice(others)

    def _from_people(self) -> Floats:
        x, y = self.at.astype(np.float32).T
        dx, dy = x[:, None] - x, y[:, None] - y
        distance = np.sqrt(dx * dx + dy * dy + 1e-12)
        ahead = (self.velocity / np.maximum(np.hypot(*self.velocity.T), 1e-6)[:, None]).astype(np.float32)
        # The cosine between where one goes and the other is.
        towards = -(dx * ahead[:, :1] + dy * ahead[:, 1:]) / distance
        seen = BEHIND + (1 - BEHIND) * 0.5 * (1 + towards)
        size = REPELS * np.exp((2 * RADIUS - distance) / np.float32(REACH)) * seen / distance
        return np.stack([(size * dx).sum(1), (size * dy).sum(1)], -1).astype(float)

    def _from_walls(self) -> Floats:
        step = 0.05
        here = self.scene.clearance(self.at)
        slope = np.stack(
            [(self.scene.clearance(self.at + d) - here) / step for d in ([step, 0.0], [0.0, step])], -1
        )
        size = 5.0 * np.exp((RADIUS - np.maximum(here, -0.5)) / 0.2)
        return np.asarray(size[:, None] * slope)

    def _from_car(self, car: tuple[float, float, float, float], body: tuple[float, ...]) -> Floats:
        """Attentive people keep away from where the car is in a second; the others only from its body."""
        x, y, heading, speed = car
        front, rear, half = body
        ux, uy = np.cos(heading), np.sin(heading)
        rel = self.at - [x, y]
        along, aside = rel @ [ux, uy], rel @ [-uy, ux]
        ahead = np.where(self.attends, front + speed * 1.0, front)
        off = np.stack([along - np.clip(along, -rear, ahead), aside - np.clip(aside, -half, half)], -1)
        distance = np.hypot(*off.T)
        # Who is inside of the area that they keep away from goes sideways.
        off = np.where((distance < 0.05)[:, None], np.stack([0 * aside, np.sign(aside + 1e-9)], -1), off)
        off /= np.maximum(np.hypot(*off.T), 1e-6)[:, None]
        size = np.where(
            self.attends,
            4.0 * np.exp((RADIUS - distance) / 0.4),
            6.0 * np.exp((RADIUS - distance) / 0.1),
        )
        size = np.minimum(size, 6.0)
        return np.asarray(size[:, None] * (off[:, :1] * [ux, uy] + off[:, 1:] * [-uy, ux]))
