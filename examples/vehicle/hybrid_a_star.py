# SPDX-License-Identifier: Apache-2.0
"""Hybrid A* (Dolgov et al., 2008): a forward path that the car's turning radius allows, over a grid."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from vehicle import car
from vehicle.scenes import Floats, Scene

CELL = 0.5  # m
ARC = 1.0  # m, of one step
HEADINGS = 36
BENDS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # of the least radius
DISCS = (0.1, 0.7, 1.3)  # m along the car: circles that cover it
DISC = 0.85  # m
SPACING = 0.25  # m between points of the path
LIKES = 1.6  # m of clearance; less costs
MOST_NODES = 30_000
SIDEWAYS = 0.6  # m/s^2 in curves


@dataclass(frozen=True)
class Path:
    """Points each SPACING of the rear axle's way; ``limit`` is the speed that curves allow, m/s."""

    points: Floats  # (n, 2)
    headings: Floats  # (n,)
    limit: Floats  # (n,)

    @property
    def length(self) -> float:
        """The whole way, m."""
        return (len(self.points) - 1) * SPACING

    def at(self, s: Floats | float) -> Floats:
        """Return the points at the distances ``s``; beyond the end the path goes straight on."""
        s = np.asarray(s, float)
        where = np.arange(len(self.points)) * SPACING
        found = np.stack([np.interp(s, where, self.points[:, k]) for k in (0, 1)], -1)
        beyond = np.maximum(s - self.length, 0)[..., None]
        last = self.headings[-1]
        return found + beyond * [np.cos(last), np.sin(last)]

    def project(self, x: float, y: float, hint: float) -> float:
        """Return the distance along the path of its point that is nearest to a place, near ``hint``."""
        first = max(0, int((hint - 2) / SPACING))
        part = self.points[first : first + int(8 / SPACING)]
        return float((first + np.argmin(np.hypot(part[:, 0] - x, part[:, 1] - y))) * SPACING)


class Grid:
    """Clearances of a scene and of people who stand, by cell."""

    def __init__(self, scene: Scene, standing: Floats) -> None:
        self.size = (int(scene.width / CELL) + 1, int(scene.height / CELL) + 1)
        xs, ys = np.meshgrid(np.arange(self.size[0]), np.arange(self.size[1]), indexing="ij")
        points = np.stack([xs, ys], -1).reshape(-1, 2) * CELL
        found = scene.clearance(points)
        for x, y in standing:
            found = np.minimum(found, np.hypot(points[:, 0] - x, points[:, 1] - y) - 0.3)
        self.clear: list[list[float]] = found.reshape(self.size).tolist()

    def at(self, x: float, y: float) -> float:
        """Return the clearance of the cell of a place; outside there is none."""
        i, j = int(x / CELL + 0.5), int(y / CELL + 0.5)
        return self.clear[i][j] if 0 <= i < self.size[0] and 0 <= j < self.size[1] else -1.0

    def distances(self, goal: tuple[float, float]) -> dict[tuple[int, int], float]:
        """Return how far each free cell is from the goal for a car that turns on the spot."""
        first = (int(goal[0] / CELL + 0.5), int(goal[1] / CELL + 0.5))
        found: dict[tuple[int, int], float] = {}
        heap = [(0.0, first)]
        moves = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
        while heap:
            far, cell = heapq.heappop(heap)
            if cell in found:
                continue
            found[cell] = far
            for i, j in moves:
                x, y = cell[0] + i, cell[1] + j
                inside = 0 <= x < self.size[0] and 0 <= y < self.size[1]
                if inside and (x, y) not in found and self.clear[x][y] >= DISC - 0.1:
                    heapq.heappush(heap, (far + CELL * (i * i + j * j) ** 0.5, (x, y)))
        return found


def plan(
    scene: Scene, start: tuple[float, float, float], standing: Floats | None = None, free: float = 0.0
) -> Path | None:
    """Return a path to the scene's goal, or None if there is none.

    ``standing`` (n, 2) are people to drive around. Within ``free`` metres of the start clearance is not asked
    for, so that a car which stands close to people finds a way out.
    """
    grid = Grid(scene, np.zeros((0, 2)) if standing is None else standing)
    to_goal = grid.distances(scene.goal)
    nodes: list[tuple[float, float, float, int, float]] = [(*start, -1, 0.0)]  # x, y, heading, parent, bend
    heap = [(0.0, 0.0, 0)]
    closed: set[tuple[int, int, int]] = set()
    while heap and len(nodes) < MOST_NODES:
        _, cost, number = heapq.heappop(heap)
        x, y, heading, _, bend = nodes[number]
        key = (int(x / CELL + 0.5), int(y / CELL + 0.5), round(heading / (2 * np.pi) * HEADINGS) % HEADINGS)
        if key in closed:
            continue
        closed.add(key)
        if np.hypot(x - scene.goal[0], y - scene.goal[1]) < ARC:
            return _path(nodes, number)
        for next_bend in BENDS:
            moved = _arc(x, y, heading, next_bend, ARC)
            room = min(
                grid.at(moved[0] + d * np.cos(moved[2]), moved[1] + d * np.sin(moved[2])) for d in DISCS
            )
            cell = (int(moved[0] / CELL + 0.5), int(moved[1] / CELL + 0.5))
            near_start = np.hypot(moved[0] - start[0], moved[1] - start[1]) < free
            if cell not in to_goal or (room < DISC and not near_start):
                continue
            more = ARC * (1 + 0.1 * abs(next_bend)) + 0.3 * abs(next_bend - bend)
            more += 0.6 * max(0.0, LIKES - room)
            nodes.append((*moved, number, next_bend))
            heapq.heappush(heap, (cost + more + to_goal[cell], cost + more, len(nodes) - 1))
    return None


def _arc(x: float, y: float, heading: float, bend: float, length: float) -> tuple[float, float, float]:
    turned = length * bend / car.TURN
    middle = heading + turned / 2
    chord = length if bend == 0 else 2 * car.TURN / bend * np.sin(turned / 2)
    return x + chord * np.cos(middle), y + chord * np.sin(middle), heading + turned


def _path(nodes: list[tuple[float, float, float, int, float]], number: int) -> Path:
    chain = []
    while number >= 0:
        chain.append(nodes[number])
        number = nodes[number][3]
    chain.reverse()
    points, headings = [chain[0][:2]], [chain[0][2]]
    for (x, y, heading, _, _), (*_, bend) in zip(chain, chain[1:], strict=False):
        for k in range(1, round(ARC / SPACING) + 1):
            at = _arc(x, y, heading, bend, k * SPACING)
            points.append(at[:2])
            headings.append(at[2])
    return path_of(np.array(points), np.array(headings))


def path_of(points: Floats, headings: Floats | None = None) -> Path:
    """Return the path through points that are SPACING apart, with what its curves allow."""
    if headings is None:
        steps = np.diff(points, axis=0)
        headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
        headings = np.append(headings, headings[-1])
    bend = np.abs(np.diff(headings, prepend=headings[0])) / SPACING
    limit = np.minimum(car.TOP, np.sqrt(SIDEWAYS / np.maximum(bend, 1e-6)))
    limit = np.array([limit[max(0, i - 2) : i + 6].min() for i in range(len(limit))])  # before the curve, too
    return Path(points, headings, limit)


def steer(path: Path, pose: car.Pose, s: float) -> float:
    """Return the steering angle of pure pursuit (Coulter, 1992) from a place ``s`` along the path."""
    ahead = 1.2 + 0.5 * pose.speed
    x, y = path.at(s + ahead)
    angle = np.arctan2(y - pose.y, x - pose.x) - pose.heading
    reach = max(0.5, float(np.hypot(x - pose.x, y - pose.y)))
    return float(np.arctan2(2 * car.BASE * np.sin(angle), reach))
