# SPDX-License-Identifier: Apache-2.0
"""Cells of a suite as a solver would leave them, made up: reports are tested without compiling anything."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypgen.experiments.cells import Cell, cells_of
from hypgen.experiments.record import record
from hypgen.experiments.store import Store
from hypgen.experiments.suite import Setting, read_suite

MACHINE = {
    "hypgen": "1.2.3",
    "system": "Linux 6.1.0",
    "cores": 16,
    "processor": "AMD EPYC 7763 64-Core Processor",
}
ABOUT = {
    "machine": MACHINE,
    "compiler": "g++ 13.2.0",
    "began": "2026-11-30T10:00:00+00:00",
    "load_average": [1.0, 1.0, 1.0],
    "seconds": 1.0,
}
_SKILL = {
    "default": 0.0,
    "rollout": 2.0,
    "despot": 4.0,
    "pomcp": 3.0,
    "parallel": 5.0,
    "gpu": 5.5,
    "hyp": 7.0,
}
_SPEED = {"despot": 100.0, "pomcp": 80.0, "parallel": 350.0, "gpu": 9000.0, "hyp": 30000.0}


def write_suite(folder: Path, text: str) -> Path:
    """Write a suite of the models that it names, which are empty files."""
    for name in ("rocks.pomdp", "tag.pomdp"):
        (folder / name).write_text("model Nothing\n")
    path = folder / "suite.toml"
    path.write_text(text)
    return path


def play(
    path: Path,
    folder: Path,
    plays: Callable[[Cell], bool] = lambda cell: True,
    machine: Callable[[Cell], dict[str, Any]] = lambda cell: MACHINE,
) -> Store:
    """Fill a folder with the cells of a suite that ``plays`` takes."""
    suite, store = read_suite(path), Store(folder)
    store.open(suite.title)
    programs = {one.task.name: "abc" for study in suite.studies for one in study.settings}
    record(suite, programs, store)
    for cell in cells_of(suite.studies, programs):
        if plays(cell):
            put(store, cell, machine(cell))
    return store


def put(store: Store, cell: Cell, machine: dict[str, Any]) -> None:
    """Keep a cell with episodes that are drawn by their numbers, so that they are paired."""
    about = ABOUT | {"machine": machine, "cores": cell.setting.threads}
    device = "NVIDIA H200" if cell.setting.wants_gpu else "cpu"
    lines: list[dict[str, Any]] = [{"type": "run", "device": device}]
    for episode in range(cell.first, cell.first + cell.runs):
        lines += _episode(cell.setting, episode)
    store.put(cell, about, "".join(json.dumps(line) + "\n" for line in lines))


def _episode(setting: Setting, episode: int) -> list[dict[str, Any]]:
    told = dict(setting.options)
    effort = float(told.get("time", told.get("trials", 1.0))) * float(told.get("threads", 1))
    world, own = random.Random(episode), random.Random(f"{episode} {setting}")
    skill = _SKILL[setting.mode] + (2.0 * math.log10(effort) if setting.mode in _SPEED else 0.0)
    earned = 8.0 + skill + world.gauss(0.0, 4.0) + own.gauss(0.0, 1.5)
    searches = setting.mode in _SPEED
    lines: list[dict[str, Any]] = []
    for step in range(3):
        expansions = int(_SPEED.get(setting.mode, 0.0) * effort * own.uniform(0.9, 1.1))
        bounds = (
            (earned - 4.0, earned + (9.0 if setting.mode == "pomcp" else 4.5)) if searches else (None, None)
        )
        lines.append(
            {
                "type": "step",
                "episode": episode,
                "step": step,
                "action_name": ("wait", "go", "wait")[step],
                "status": "time_limit" if searches else "none",
                "search_seconds": float(told.get("time", 0.1)) if searches else 1e-5,
                "update_seconds": 1e-4,
                "lower": bounds[0],
                "upper": bounds[1],
                "expansions": expansions,
                "nodes": 12 * expansions,
                "trials": expansions // 3,
                "simulations": 500 * expansions,
                "collisions": 0,
                "max_depth": int(4 * math.log10(10 * expansions)) if expansions else 0,
            }
        )
    success = own.random() < 1.0 / (1.0 + math.exp(-(skill - 3.0) / 2.0))
    return [
        *lines,
        {
            "type": "episode",
            "episode": episode,
            "discounted_return": earned,
            "steps": 3 + world.randrange(20),
            "status": "terminal",
            "terminal": True,
            "success": success,
            "visible": {"robot.x": episode},
        },
    ]
