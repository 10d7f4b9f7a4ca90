# SPDX-License-Identifier: Apache-2.0
"""Scenes of cells in a terminal, and what ``hypgen sim`` draws of an episode."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from hypgen.cli.commands.sim import command
from hypgen.cli.show.scene_text import scene_lines

ROOT = Path(__file__).parents[3]
SCENE = {
    "extent": {"cells": True, "x": [0, 3], "y": [0, 1]},
    "static": [{"shape": "cell", "name": "wall", "x": 3, "y": 1, "colour": "grey"}],
}
MOMENT = {
    "truth": [
        {"shape": "cell", "name": "rock", "x": 0, "y": 1, "colour": "green", "text": "7"},
        {"shape": "marker", "name": "robot", "x": 1, "y": 0, "colour": "blue", "heading": 1.6},
        {"shape": "marker", "name": "far", "x": 9, "y": 0, "colour": "blue"},
        {"shape": "gauge", "name": "power", "colour": "blue", "value": 1, "low": 0, "high": 4},
    ],
    "belief": [
        {"shape": "cell", "name": "rock", "x": x, "y": 0, "colour": "green", "p": p}
        for x, p in ((0, 0.2), (1, 0.5), (2, 0.6), (3, 1.0))
    ],
}


def test_a_scene_is_plain_characters_where_nobody_sees_colours() -> None:
    assert scene_lines(SCENE, MOMENT, coloured=False) == [
        "  7 . . #",
        "  ░ ^ ▓ █",
        "  power [=====---------------] 1",
    ]


def test_colours_show_what_is_true_and_shades_what_is_believed() -> None:
    above, below, _ = scene_lines(SCENE, MOMENT, coloured=True)
    assert "\x1b[38;2;255;255;255m\x1b[48;2;0;158;115m7 " in above
    assert "\x1b[48;2;154;154;154m  " in above, "a wall is its colour alone"
    assert "\x1b[48;2;64;182;150m  " in below, "three quarters of green"


def test_a_plane_is_not_drawn_as_cells() -> None:
    plane = SCENE | {"extent": {"cells": False, "x": [0, 3], "y": [0, 1]}}
    assert scene_lines(plane, {"truth": MOMENT["truth"][-1:]}, coloured=False) == [
        "  power [=====---------------] 1"
    ]


@pytest.mark.parametrize("hide", [True, False])
def test_sim_draws_what_is_true_or_believed(hide: bool) -> None:
    words = [
        str(ROOT / "examples" / "rock_sample.pomdp"),
        "--draw",
        "--policy",
        "default",
        "--steps",
        "1",
    ]
    output = CliRunner().invoke(command, [*words, "--hide-hidden"] if hide else words).stdout.splitlines()
    assert output.count("  R . . . . . ▒ #" if hide else "  R . . . . . 3 #") == 2


def test_sim_draws_nothing_unasked_where_nobody_looks() -> None:
    words = [str(ROOT / "examples" / "rock_sample.pomdp"), "--policy", "default", "--steps", "1"]
    assert "▒" not in CliRunner().invoke(command, words).stdout
