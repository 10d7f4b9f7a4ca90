# SPDX-License-Identifier: Apache-2.0
"""Draws layouts for the tasks whose papers draw them anew for each run, and writes them as lists of params.

python3 benchmarks/layouts.py

The episodes of a cell of `hypgen bench` share a layout. Each file is the same each time.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "models" / "layouts"
COUNT = 20  # layouts of a file
Layout = dict[str, Any]
Cell = tuple[int, int]


def rocks(size: int, starts: Iterable[Cell], draw: random.Random) -> Layout:
    """Return as many rocks as the map has rows, on distinct cells off the starts."""
    cells = [(x, y) for x in range(size) for y in range(size) if (x, y) not in starts]
    chosen = sorted(draw.sample(cells, size))
    return {"rock_x": [x for x, _ in chosen], "rock_y": [y for _, y in chosen]}


def two_robots(size: int) -> Callable[[random.Random], Layout]:
    """Return what draws the rocks of two-robot RockSample."""
    return lambda draw: rocks(size, [(0, size // 2 + 1), (0, size // 2 - 1)], draw)


def one_robot(draw: random.Random) -> Layout:
    """Return the rocks of RockSample(15,15)."""
    return rocks(15, [(0, 7)], draw)


def navigation_map(draw: random.Random) -> Layout:
    """Return a map of navigation with 31 known obstacles, neither on the wall nor on the goal."""
    rows = [["unknown"] * 13 for _ in range(13)]
    rows[6] = ["wall"] * 13
    rows[6][3], rows[6][9], rows[0][6] = "west_gate", "east_gate", "goal"
    free = [(x, y) for y in range(13) for x in range(13) if rows[y][x] == "unknown"]
    for x, y in draw.sample(free, 31):
        rows[y][x] = "obstacle"
    return {"map": rows}


FILES: dict[str, Callable[[random.Random], Layout]] = {
    "two_robots_15.json": two_robots(15),
    "two_robots_20.json": two_robots(20),
    "two_robots_50.json": two_robots(50),
    "one_robot_15.json": one_robot,
    "navigation.json": navigation_map,
}


def text_of(name: str) -> str:
    """Return a file's text: a layout a line."""
    draw = random.Random(f"layouts of {name}")
    return "[" + ",\n".join(json.dumps(FILES[name](draw)) for _ in range(COUNT)) + "]\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name in FILES:
        (FOLDER / name).write_text(text_of(name), encoding="utf-8")
