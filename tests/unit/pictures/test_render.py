# SPDX-License-Identifier: Apache-2.0
"""View data become PNG and GIF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("matplotlib", reason="pictures need the extra draw")

from PIL import Image

from hypgen.pictures import render_gif, render_png

SCENE = {
    "extent": {"cells": True, "x": [0, 2], "y": [0, 1]},
    "static": [
        {"shape": "cell", "name": "wall", "x": 1, "y": 1, "colour": "grey"},
        {"shape": "line", "name": "way", "x": 0, "y": 0, "x2": 2, "y2": 0, "colour": "yellow"},
        {"shape": "label", "name": "note", "x": 0, "y": 1, "colour": "black", "text": "yard"},
    ],
}
TRUTH = [
    {"shape": "cell", "name": "rock", "x": 0, "y": 0, "colour": "green", "text": "0"},
    {"shape": "marker", "name": "robot", "x": 2, "y": 0, "colour": "blue", "heading": 1.0},
    {"shape": "rectangle", "name": "car", "x": 1, "y": 0, "width": 1, "height": 0.5, "colour": "red"},
    {"shape": "gauge", "name": "power", "colour": "blue", "value": 2, "low": 0, "high": 4},
]
BELIEF = [shape | {"p": 0.25} for shape in TRUTH]


def view(steps: int = 3, **changed: Any) -> dict[str, Any]:
    step = {"action": "go", "reward": -1.0, "seen": {"near": True}, "truth": TRUTH, "belief": BELIEF}
    bounds = {"upper": 2.0, "lower": 1.0, "earned": 1.5}
    shown = [{"step": n, **step, **bounds} for n in range(steps)]
    return {"scene": SCENE, "steps": shown, "end": {"truth": TRUTH, "belief": []}} | changed


def test_a_step_is_a_png(tmp_path: Path) -> None:
    render_png(view(), 1, tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert image.format == "PNG"
        assert image.width > 500
    render_png(view(), 1, tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_what_is_believed_is_paler_than_what_is_true(tmp_path: Path) -> None:
    def greens(shapes: list[dict[str, Any]]) -> tuple[int, int]:
        step = {
            "step": 0,
            "action": "go",
            **({"truth": shapes} if "p" not in shapes[0] else {"belief": shapes}),
        }
        render_png({"scene": SCENE, "steps": [step], "end": None}, 0, tmp_path / "c.png")
        with Image.open(tmp_path / "c.png") as image:
            colours = image.convert("RGB").getcolors(1 << 20) or []
        return (
            sum(n for n, c in colours if c == (0, 0x9E, 0x73)),
            sum(n for n, (r, g, b) in colours if g > r + 5 and g > b and r > 100),
        )

    solid, _ = greens(TRUTH[:1])
    none, pale = greens(BELIEF[:1])
    assert solid > 1000
    assert none == 0
    assert pale > 1000


def test_an_episode_is_a_gif_of_its_steps_and_its_end(tmp_path: Path) -> None:
    render_gif(view(2), tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as image:
        assert image.format == "GIF"
        assert getattr(image, "n_frames", 1) == 3


def test_a_model_without_drawings_shows_words_and_curves(tmp_path: Path) -> None:
    render_png(view(scene=None), 0, tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 1000


@pytest.mark.parametrize("step", [-1, 4])
def test_a_step_that_there_is_not_is_refused(tmp_path: Path, step: int) -> None:
    with pytest.raises(ValueError, match="the episode has the steps 0 to 2, and its end"):
        render_png(view(), step, tmp_path / "a.png")


def test_shapes_outside_the_picture_are_cut_off(tmp_path: Path) -> None:
    far = [shape | {"x": 1e6, "y": -50} for shape in TRUTH] + [
        {"shape": "label", "name": "far", "x": 40, "y": 0, "colour": "black", "text": "far"},
        {"shape": "line", "name": "long", "x": 0, "y": 0, "x2": 1e6, "y2": 0, "colour": "red"},
    ]
    sizes = []
    for name, truth in (("near.png", TRUTH), ("far.png", far)):
        shown = view(1)
        shown["steps"][0] |= {"truth": truth, "belief": []}
        render_png(shown, 0, tmp_path / name)
        with Image.open(tmp_path / name) as image:
            sizes.append(image.size)
    assert sizes[0] == sizes[1]
