# SPDX-License-Identifier: Apache-2.0
"""Whole drives of examples/vehicle, and their table."""

import json
import sys
from pathlib import Path

import pytest
from vehicle import drive, drives, policies, report, scenes
from vehicle.world import World

import hypgen

ROOT = Path(__file__).parents[3]


def test_a_rule_drives_to_the_goal() -> None:
    scene = scenes.make("crossing", 3, 20)
    found = drive.Drive(World(scene, 3), policies.Reactive(), 10)
    found.play(60)
    line = drive.summary(found)
    assert line["arrived"] and 20 < float(str(line["metres"])) < 40
    assert line["decisions"] == pytest.approx(10 * found.world.counts.seconds, abs=2)


def test_drives_are_played_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "drives.jsonl"
    monkeypatch.setattr(drives, "MOST_SECONDS", 0.2)
    for count in (1, 2):
        words = f"drives --out {out} --rows reactive,ttc --scenes group --drives {count} --people 20"
        monkeypatch.setattr(sys, "argv", words.split())
        drives.main()
    lines = [json.loads(line) for line in out.read_text().splitlines()]
    assert [(line["row"], line["seed"]) for line in lines] == [
        *(("reactive", 0), ("ttc", 0)),
        *(("reactive", 1), ("ttc", 1)),
    ]
    text = report.tables(lines)
    assert text.startswith("3 Hz, wrong: none") and text.count("| reactive | 2 |") == 1


@pytest.mark.slow
@pytest.mark.cxx
def test_a_generated_solver_drives_to_the_goal() -> None:
    solver = hypgen.load(ROOT / "examples" / "vehicle" / "vehicle.pomdp").compile(target="cpu")
    scene = scenes.make("crossing", 3, 20)
    policy = policies.make("despot", solver, scene.exits, 1 / 3, 1)
    found = drive.Drive(World(scene, 3), policy, 3, budget=0.1)
    found.play(90)
    line = drive.summary(found)
    assert line["arrived"] and line["front_hits"] == 0 and line["odd_updates"] == 0
