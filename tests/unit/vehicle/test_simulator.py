# SPDX-License-Identifier: Apache-2.0
"""The simulated world of examples/vehicle: scenes, people, the car, what a lidar sees, what is counted."""

import numpy as np
import pytest
from vehicle import car, scenes, sensor
from vehicle.car import Car, Pose
from vehicle.sensor import Sensor
from vehicle.world import TICK, World


@pytest.mark.parametrize("name", scenes.SCENES)
@pytest.mark.parametrize("people", [20, 300])
def test_a_scene_follows_from_its_seed_and_its_people_stay_in_it(name: str, people: int) -> None:
    first, second, other = (scenes.make(name, seed, people) for seed in (3, 3, 4))
    assert np.array_equal(first.people, second.people) and not np.array_equal(first.people, other.people)
    assert len(first.people) == people and first.clearance(first.people).min() > 0
    world = World(first, 3)
    for _ in range(20):
        world.step()
    assert first.clearance(world.crowd.at).min() > -0.3
    assert np.hypot(*world.crowd.velocity.T).max() < 3


def test_people_walk_to_their_exits_and_keep_apart() -> None:
    world = World(scenes.make("plaza", 1, 40), 1)
    exits, aims = world.scene.exits, world.crowd.aims.copy()
    walks = aims >= 0
    before = np.hypot(*(exits[aims] - world.crowd.at).T)
    for _ in range(90):
        world.step()
    after = np.hypot(*(exits[aims] - world.crowd.at).T)
    same = walks & (world.crowd.aims == aims)
    assert np.median((before - after)[same]) > 1.5
    apart = np.hypot(*(world.crowd.at[:, None] - world.crowd.at).transpose(2, 0, 1)) + 9 * np.eye(40)
    assert apart.min() > 0.2


def test_the_car_moves_after_its_delay_and_turns_no_tighter_than_it_can() -> None:
    robot = Car((0.0, 0.0, 0.0), np.random.default_rng(1), TICK)
    speeds = []
    for _ in range(60):
        robot.command(0.8, 1.5)
        robot.step()
        speeds.append(robot.pose.speed)
    assert speeds[1] == 0.0 and 1.0 < speeds[-1] < 1.7
    way = sum(speeds) * TICK
    assert robot.pose.heading < 1.15 * way / car.TURN
    for _ in range(120):
        robot.command(-2.5, 0.0)
        robot.step()
    assert robot.pose.speed == 0.0


def test_a_lidar_misses_some_invents_some_and_swaps_labels() -> None:
    at = np.array([[5.0, 0.0], [5.0, 4.0], [5.0, -4.0], [10.0, 0.0], [-6.0, 0.3], [-6.0, -0.3]])
    lidar, seen, false, swapped = Sensor(len(at), np.random.default_rng(2)), np.zeros(len(at)), 0, 0
    for _ in range(400):
        scan = lidar.scan(at, Pose(0, 0, 0, 0))
        away = np.hypot(*(scan.at[:, None] - at).transpose(2, 0, 1))
        seen += (away < 0.5).any(0)
        false += int((away.min(1) > 1).sum())
        swapped += int(lidar._labels[4] > lidar._labels[5])
    share = seen / 400
    assert np.all(abs(share[[0, 1, 2]] - (1 - sensor.MISSES)) < 0.04)
    assert share[3] < 0.4, "who stands behind another is mostly missed"
    assert 60 < false < 180 and swapped > 20


def test_contact_counts_once_and_by_where_it_is() -> None:
    scene = scenes.make("plaza", 1, 20)
    scene.people[:] = [30, 30]
    scene.people[0] = [scene.start[0] + car.FRONT + 0.2, scene.start[1]]
    scene.people[1] = [scene.start[0], scene.start[1] + car.HALF + 0.2]
    world = World(scene, 1)
    world.crowd.step = lambda *_: None  # type: ignore[method-assign]
    world.car.pose = Pose(*scene.start, 0.0)
    world._count(0.0)
    assert world.counts.hits == 0, "a car that stands hits nobody"
    world.car.pose = Pose(*scene.start, 1.0)
    for _ in range(3):
        world._count(0.0)
    counts = world.counts
    assert (counts.hits, counts.front_hits, counts.fast_hits, counts.near) == (2, 1, 1, 0)
