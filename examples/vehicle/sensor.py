# SPDX-License-Identifier: Apache-2.0
"""Detections as from a lidar: with noise, misses, false ones, and labels that get swapped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle.car import Pose
from vehicle.scenes import Floats

RANGE = 20.0  # m
NOISE = 0.08  # m
MISSES, MISSES_HIDDEN = 0.05, 0.8  # of all, and of who stands behind another
FALSE = 0.3  # a scan
SWAPS = 0.1  # of pairs closer than 0.8 m
RELABELS = 0.02  # of all detections


@dataclass(frozen=True)
class Scan:
    """Detected places (n, 2) in m, and a label each that mostly stays a person's."""

    at: Floats
    labels: npt.NDArray[np.int64]


class Sensor:
    """Scans one crowd."""

    def __init__(self, people: int, random: np.random.Generator, *, noise: float = 1.0) -> None:
        self._random, self._noise = random, NOISE * noise
        self._labels = np.arange(people)
        self._next = people

    def scan(self, at: Floats, car: Pose) -> Scan:
        """Return what is detected of people at (people, 2), seen from the car."""
        random = self._random
        rel = at - [car.x, car.y]
        distance = np.hypot(*rel.T)
        misses = np.where(self._hidden(rel, distance), MISSES_HIDDEN, MISSES)
        seen = np.flatnonzero((distance < RANGE) & (random.random(len(at)) >= misses))
        self._swap(at)
        new = seen[random.random(len(seen)) < RELABELS]
        self._labels[new] = self._fresh(len(new))
        false = int(random.poisson(FALSE))
        angle, radius = random.uniform(-np.pi, np.pi, false), RANGE * np.sqrt(random.random(false))
        ghosts = [car.x, car.y] + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
        found = at[seen] + random.normal(0, self._noise, (len(seen), 2))
        return Scan(np.concatenate([found, ghosts]), np.concatenate([self._labels[seen], self._fresh(false)]))

    def _fresh(self, count: int) -> npt.NDArray[np.int64]:
        self._next += count
        return np.arange(self._next - count, self._next)

    def _hidden(self, rel: Floats, distance: Floats) -> npt.NDArray[np.bool_]:
        near = np.flatnonzero(distance < RANGE)
        angle, far = np.arctan2(rel[near, 1], rel[near, 0]), distance[near]
        apart = np.abs(angle[:, None] - angle)
        covers = np.minimum(apart, 2 * np.pi - apart) < np.arctan2(0.2, np.maximum(far, 0.3))
        found = np.zeros(len(rel), bool)
        found[near] = (covers & (far < far[:, None] - 0.3)).any(1)
        return found

    def _swap(self, at: Floats) -> None:
        apart = np.hypot(at[:, None, 0] - at[:, 0], at[:, None, 1] - at[:, 1])
        first, second = np.nonzero(np.triu(apart < 0.8, 1))
        for i, j in zip(first, second, strict=True):
            if self._random.random() < SWAPS:
                self._labels[[i, j]] = self._labels[[j, i]]
