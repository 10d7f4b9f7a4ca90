# SPDX-License-Identifier: Apache-2.0
"""Recordings as a solver writes them, of episodes of Tiger that the interpreter plays."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hypgen.dsl.interpret.episode import Episode
from hypgen.dsl.load import load
from support.seen_episodes import HOSTILE

TIGER = (Path(__file__).parents[2] / "examples" / "tiger.pomdp").read_text()
HINTS = """
draw door[d in Door] = cell { x = index(d), y = 0, colour = white, text = d }
draw tiger = marker { x = index(room.tiger), y = 0, colour = orange, text = "T" }
draw note = label { x = 0, y = 0, text = "</script>" }
"""
ACTIONS = ("listen", "open_left", "open_right")
DOORS = ("left", "right")
_NEVER = {"tree": None, "tree_shown": 0, "tree_total": 0, "lower": 1.5, "upper": 3.0}


def model_file(folder: Path, hints: str = HINTS) -> Path:
    """Write Tiger with hints for its picture."""
    path = folder / "tiger.pomdp"
    path.write_text(TIGER + hints)
    return path


def lines_of(path: Path, *, episodes: tuple[int, ...] = (3, 4), count: int = 3) -> list[dict[str, Any]]:
    """Return the lines of a recording: episodes of so many steps, which their step limit ends."""
    model = load(path).model
    tiger = {"name": "room.tiger", "type": "named", "dims": [], "visible": False, "values": list(DOORS)}
    lines: list[dict[str, Any]] = [
        {
            "type": "recording",
            "version": 1,
            "kind": "episode",
            "model": f"Tiger {HOSTILE}",
            "hash": model.source_hash,
            "file": "tiger.pomdp",
            "discount": model.discount,
            "horizon": None,
            "options": {"seed": 5, "mode": "despot", "threads": 3},
            "params": {"hearing": 0.85},
            "actions": list(ACTIONS),
            "variables": [tiger],
        }
    ]
    for number in episodes:
        world = Episode(model, seed=5, number=number)
        lines.append({"type": "start", "episode": number, "visible": {}})
        for at in range(count):
            lines.append(_step(world, number, at))
        end = {"steps": count, "discounted_return": 0.0, "status": "ok", "terminal": False}
        lines.append({"type": "episode", "episode": number, **end, "state": _state(world)})
    return lines


def write(path: Path, lines: list[dict[str, Any]]) -> Path:
    """Write lines as a solver does."""
    path.write_text("".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines))
    return path


def _state(world: Episode) -> dict[str, str]:
    return {"room.tiger": DOORS[world.values()["room.tiger"][0]]}


def _step(world: Episode, number: int, at: int) -> dict[str, Any]:
    state, action = _state(world), at % 2
    outcome = world.step(action)
    marginal = {"variable": "room.tiger", "values": [{"value": d, "probability": 0.5} for d in DOORS]}
    return {
        "type": "step",
        "episode": number,
        "step": at,
        "action": action,
        "action_name": ACTIONS[action],
        "default_action": "listen",
        "reward": outcome.reward,
        "terminal": False,
        "seen": {"heard": "left"},
        "state": state,
        "sampled": {"room.tiger": ["left"] * 3 + ["right"]},
        "particles_total": 100,
        "marginals": [marginal],
        "status": "deadline",
        "nodes": 10 + at,
        "search_seconds": 0.1,
        "update_seconds": 0.001,
        "effective_sample_size": 90.0,
        **_NEVER,
    }
