# SPDX-License-Identifier: Apache-2.0
"""Places to drive through: walls, exits that people walk to, a start and a goal, all from a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

WALKS = 1.2  # m/s, the mean speed of who walks


@dataclass(frozen=True)
class Scene:
    """A place and its people. Lengths are metres, angles radians, and the origin is the lower left corner."""

    name: str
    width: float
    height: float
    start: tuple[float, float, float]  # x, y, heading of the rear axle
    goal: tuple[float, float]
    exits: Floats  # (exits, 2)
    people: Floats  # (people, 2): where they begin
    aims: npt.NDArray[np.int64]  # (people,): an exit each, or -1 for who stands
    columns: Floats = field(default_factory=lambda: np.zeros((0, 3)))  # (columns, 3): x, y, radius
    walls: Floats = field(default_factory=lambda: np.zeros((0, 4)))  # (walls, 4): x, y, x2, y2 of rectangles

    def clearance(self, points: Floats) -> Floats:
        """Return how far each of the points (n, 2) is from columns, walls and the border; below 0 inside."""
        x, y = points[:, 0], points[:, 1]
        found = np.minimum.reduce([x, y, self.width - x, self.height - y])
        for cx, cy, radius in self.columns:
            found = np.minimum(found, np.hypot(x - cx, y - cy) - radius)
        for x1, y1, x2, y2 in self.walls:
            dx, dy = np.maximum(x1 - x, x - x2), np.maximum(y1 - y, y - y2)
            outside = np.hypot(np.maximum(dx, 0), np.maximum(dy, 0))
            found = np.minimum(found, outside + np.minimum(np.maximum(dx, dy), 0))
        return found


def _placed(
    random: np.random.Generator, count: int, low: tuple[float, float], high: tuple[float, float]
) -> Floats:
    return random.uniform(low, high, (count, 2))


def _away_from_start(scene: Scene) -> Scene:
    """Move who stands on a wall, or within 4 m of the car, to the nearest free place of a grid."""
    grid = np.stack(np.meshgrid(np.arange(0.5, scene.width), np.arange(0.5, scene.height)), -1).reshape(-1, 2)
    start = np.array(scene.start[:2])
    free = grid[(scene.clearance(grid) > 0.5) & (np.hypot(*(grid - start).T) > 4)]
    wrong = (scene.clearance(scene.people) < 0.3) | (np.hypot(*(scene.people - start).T) < 4)
    for i in np.flatnonzero(wrong):
        scene.people[i] = free[np.argmin(np.hypot(*(free - scene.people[i]).T))]
    return scene


def plaza(random: np.random.Generator, people: int) -> Scene:
    """An open square with a fountain; people cross it in all directions."""
    exits = np.array([[1, 10], [1, 30], [39, 10], [39, 30], [20, 1], [20, 39]], float)
    columns = np.array([[20, 20, 3.0], [10, 27, 0.8], [30, 13, 0.8]], float)
    at = _placed(random, people, (1, 1), (39, 39))
    aims = random.integers(0, 6, people)
    aims[random.random(people) < 0.15] = -1
    return Scene("plaza", 40, 40, (3, 19, 0), (37, 21), exits, at, aims, columns)


def crossing(random: np.random.Generator, people: int) -> Scene:
    """A street that people cross between two squares."""
    walls = np.array([[0, 0, 14, 14], [26, 0, 40, 14], [0, 22, 14, 36], [26, 22, 40, 36]], float)
    exits = np.array([[17, 1], [23, 1], [17, 35], [23, 35]], float)
    at = _placed(random, people, (15, 1), (25, 35))
    aims = random.integers(0, 4, people)
    return Scene("crossing", 40, 36, (3, 18, 0), (37, 18), exits, at, aims, walls=walls)


def corridor(random: np.random.Generator, people: int) -> Scene:
    """A passage nine metres wide; people walk along it both ways, and some stop at its sides."""
    exits = np.array([[1, 2], [1, 7], [49, 2], [49, 7]], float)
    columns = np.array([[18, 0.8, 0.8], [30, 8.2, 0.8]], float)
    at = _placed(random, people, (6, 0.6), (49, 8.4))
    aims = random.integers(0, 4, people)
    aims[random.random(people) < 0.1] = -1
    return Scene("corridor", 50, 9, (2, 4.5, 0), (47, 4.5), exits, at, aims, columns)


def group(random: np.random.Generator, people: int) -> Scene:
    """People stand together in circles, one of them in the way; a few others walk by."""
    exits = np.array([[1, 3], [1, 21], [39, 3], [39, 21]], float)
    centres = np.array([[20, 12.0], [13, 6.5], [28, 17.5]]) + random.normal(0, 0.7, (3, 2))
    standing = people * 6 // 10
    circle, angle = random.integers(0, 3, standing), random.uniform(0, 2 * np.pi, standing)
    radius = 0.8 + 0.012 * standing + random.normal(0, 0.15, standing)
    at = np.concatenate(
        [
            centres[circle] + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1),
            _placed(random, people - standing, (1, 1), (39, 23)),
        ]
    )
    aims = np.concatenate([np.full(standing, -1), random.integers(0, 4, people - standing)])
    return Scene("group", 40, 24, (3, 12, 0), (37, 12), exits, at, aims)


SCENES: dict[str, Callable[[np.random.Generator, int], Scene]] = {
    "plaza": plaza,
    "crossing": crossing,
    "corridor": corridor,
    "group": group,
}


def make(name: str, seed: int, people: int) -> Scene:
    """Return a scene with so many people, the same for the same seed."""
    random = np.random.default_rng([seed, sorted(SCENES).index(name), people])
    return _away_from_start(SCENES[name](random, people))
