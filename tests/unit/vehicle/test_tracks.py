# SPDX-License-Identifier: Apache-2.0
"""Tracks of examples/vehicle: born, missed, found again, dead; and the bridge that keeps their beliefs."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from vehicle import hybrid_a_star, scenes
from vehicle.bridge import Bridge, Situation, first_belief
from vehicle.sensor import Scan
from vehicle.tracks import Tracks

import hypgen
from hypgen.api.planner import Planner

ROOT = Path(__file__).parents[3]
PEOPLE = 8


def scan(*places: tuple[float, float, int]) -> Scan:
    found = np.array(places, float).reshape(-1, 3)
    return Scan(found[:, :2], found[:, 2].astype(np.int64))


def watched(steps: int = 10) -> Tracks:
    """Return tracks of one person who walks along the x axis at 1 m/s and is called 7."""
    tracks = Tracks(first_belief(2, 6))
    for k in range(steps):
        tracks.step(scan((0.1 * k, 0.0, 7)), 0.1)
    return tracks


def test_somebody_is_there_after_three_detections() -> None:
    assert [watched(steps).seen().sum() for steps in (1, 2, 3)] == [0, 0, 1]
    ghost = Tracks(np.ones(1))
    ghost.step(scan((3, 3, 1)), 0.1)
    for _ in range(4):
        ghost.step(scan(), 0.1)
    assert len(ghost.at) == 0


def test_velocity_is_learnt_and_coasts() -> None:
    tracks = watched(20)
    assert tracks.velocity[0] == pytest.approx([1.0, 0.0], abs=0.15)
    for _ in range(4):
        tracks.step(scan(), 0.1)
    assert tracks.seen().all() and tracks.at[0, 0] == pytest.approx(2.3, abs=0.15)


def test_who_is_found_again_has_the_belief_of_before() -> None:
    tracks = watched(20)
    tracks.intent[0] = np.eye(8)[3]
    for _ in range(12):
        tracks.step(scan(), 0.1)
    assert not tracks.seen().any()
    tracks.step(scan((2.9, 0.1, 99)), 0.1)  # another label
    assert tracks.found_again == 1 and tracks.seen().all()
    assert tracks.intent[0, 3] == 1.0
    for _ in range(40):
        tracks.step(scan(), 0.1)
    assert len(tracks.at) == 0


def test_swapped_labels_swap_nobody() -> None:
    tracks = Tracks(np.ones(1))
    for k in range(20):
        first, second = (1, 2) if k < 12 else (2, 1)
        tracks.step(scan((0.1 * k, 0.0, first), (0.1 * k, 1.0, second)), 0.1)
    assert len(tracks.at) == 2
    assert tracks.at[np.argsort(tracks.id), 1] == pytest.approx([0.0, 1.0], abs=0.1)


class Recorded(Planner):
    """A planner that notes what it is told, and believes what it is told to."""

    def __init__(self) -> None:
        dims = {"ped.x": [PEOPLE], "car.px": [25], "car.exit_x": [6]}
        self.visible_fields: Any = [SimpleNamespace(name=n, dims=d) for n, d in dims.items()]
        self.told: list[dict[str, Any]] = []
        self._handle = None

    def reset(self, visible: Any = None, *, episode: int = 0) -> str:
        self.told.append(visible)
        return "ok"

    def update(self, action: int | str, seen: Any) -> str:
        self.told.append(seen)
        return "ok"

    def plan(self, seconds: float = 0.0, *, deadline: float | None = None) -> Any:
        return SimpleNamespace(name="maintain", status="ok", trials=1)

    @property
    def belief(self) -> Any:
        return {f"ped.intent[{i}]": {"stand": 0.25, "exit(1)": 0.75} for i in range(PEOPLE)}


def test_a_decision_carries_the_belief_of_each_track_in_and_out() -> None:
    scene = scenes.make("plaza", 1, 20)
    path = hybrid_a_star.plan(scene, scene.start)
    assert path is not None
    planner = Recorded()
    bridge = Bridge(planner, scene.exits[:2], period=0.1)
    tracks = bridge.tracks()
    x, y = scene.start[0] + 5, scene.start[1]
    for k in range(12):
        tracks.step(scan((x, y + 0.1 * k, 7), (x + 3, y - 0.1 * k, 8)), 0.1)
    situation = Situation(path, 0.5, 1.0, tracks, 0.1)
    bridge.decide(situation, 0.0)
    assert len(planner.told) == 1, "nobody was there at the decision before"
    bridge.decide(situation, 0.0)
    before, seen, now = planner.told[1:]
    assert before["ped.prior"][0] == pytest.approx(first_belief(2, 6))
    assert seen["ped.y"][0] == pytest.approx(y + 1.1, abs=0.1) and seen["ped.x"][2] == 1000.0
    assert tracks.intent[0] == pytest.approx([0.25, 0, 0.001, 0.75, 0, 0, 0, 0], abs=0.002)
    assert now["ped.prior"][0] == pytest.approx(tracks.intent[0])
    assert now["car.px"][0] == pytest.approx(path.at(0.5)[0]) and len(now["car.limit"]) == 25


def test_the_nearest_people_are_those_near_the_path() -> None:
    scene = scenes.make("crossing", 1, 20)
    path = hybrid_a_star.plan(scene, scene.start)
    assert path is not None
    bridge = Bridge(Recorded(), scene.exits, period=0.1)
    tracks = bridge.tracks()
    places = [(15 + k, 18 + (1 if k % 2 else -8), k) for k in range(12)]
    for _ in range(4):
        tracks.step(scan(*places), 0.1)
    chosen = bridge.nearest(Situation(path, 10.0, 1.0, tracks, 0.0))
    assert len(chosen) == PEOPLE and set(tracks.label[chosen[:5]]) == {1, 3, 5, 7, 9}


def test_the_bridge_names_the_variables_of_the_model() -> None:
    scene = scenes.make("plaza", 1, 20)
    path = hybrid_a_star.plan(scene, scene.start)
    assert path is not None
    bridge = Bridge(Recorded(), scene.exits, period=0.1)
    told = bridge.state(Situation(path, 0.0, 0.0, bridge.tracks(), 0.1), np.zeros(0, np.int64))
    model = hypgen.load(ROOT / "examples" / "vehicle" / "vehicle.pomdp").loaded.model
    visible = {v.name for v in model.variables if v.visible}
    assert set(told) <= visible and visible - set(told) == {"car.begun", "car.s"}
