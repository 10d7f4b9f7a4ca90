# SPDX-License-Identifier: Apache-2.0
"""Hybrid A* of examples/vehicle: ways that the car can drive, around what stands there."""

import numpy as np
import pytest
from vehicle import car, hybrid_a_star, scenes
from vehicle.car import Pose
from vehicle.hybrid_a_star import SPACING


@pytest.mark.parametrize("name", scenes.SCENES)
def test_a_path_is_free_and_no_curve_is_too_tight(name: str) -> None:
    scene = scenes.make(name, 2, 40)
    path = hybrid_a_star.plan(scene, scene.start)
    assert path is not None
    assert np.hypot(*(path.points[-1] - scene.goal)) < 1.5
    assert scene.clearance(path.points).min() > car.HALF
    turns = np.abs(np.angle(np.exp(1j * np.diff(path.headings))))
    assert turns.max() <= SPACING / car.TURN + 1e-9
    assert np.allclose(np.hypot(*np.diff(path.points, axis=0).T), SPACING, rtol=0.01)


def test_a_path_goes_around_people_who_stand() -> None:
    scene = scenes.make("group", 1, 20)
    standing = np.array([[20.0, y] for y in np.arange(9.0, 15.1, 0.5)])
    path = hybrid_a_star.plan(scene, scene.start, standing)
    assert path is not None
    apart = np.hypot(*(path.points[:, None] - standing).transpose(2, 0, 1))
    assert apart.min() > car.HALF + 0.25


def test_where_there_is_no_way_there_is_no_path() -> None:
    scene = scenes.make("corridor", 1, 20)
    wall = np.array([[25.0, y] for y in np.arange(0.0, 9.1, 0.4)])
    assert hybrid_a_star.plan(scene, scene.start, wall) is None


def test_pursuit_steers_back_to_the_path() -> None:
    scene = scenes.make("crossing", 1, 20)
    path = hybrid_a_star.plan(scene, scene.start)
    assert path is not None
    x, y = path.at(4.0)
    left, right = Pose(x, y + 0.5, 0.0, 1.0), Pose(x, y - 0.5, 0.0, 1.0)
    assert hybrid_a_star.steer(path, left, 4.0) < 0 < hybrid_a_star.steer(path, right, 4.0)
    assert path.project(x, y + 0.5, 3.5) == pytest.approx(4.0, abs=SPACING)
