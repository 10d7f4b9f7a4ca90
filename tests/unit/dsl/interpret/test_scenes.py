# SPDX-License-Identifier: Apache-2.0
"""States become shapes as the model's ``draw`` declarations say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from support.random_models.generator import model as random_model

from hypgen.dsl import ir
from hypgen.dsl.interpret.episode import Episode
from hypgen.dsl.interpret.scenes import MOST_SHAPES, Scenes
from hypgen.dsl.load import load
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source

ROOT = Path(__file__).parents[4]
MODEL = """model Yard
type X = 0 .. 3
enum Side { near "n", far }
enum Act { wait, go }
discount 0.9
action act: Act
param reach: float = 2.0
element cart {
  visible x: X
  hidden at: float
  hidden side: Side
  hidden ripe: bool[X]
  init x = 1
  init at = 0.5
  init side = far
  init ripe = [true, false, true, false]
  x' = x
  at' = at
  side' = side
  ripe' = [i in X: ripe[i]]
}
observe seen: bool ~ noisy(cart.ripe[0]', 0.9)
reward r = if cart.side == near and cart.at > 0.0 then 1 else 0
policy default = wait
"""
DRAWN = """draw world = area { x = -1, y = 0, x2 = 4, y2 = 3 }
draw edge = line { x = 0, y = 0, x2 = reach, y2 = 0, colour = grey }
draw ripe[i in X where cart.ripe[i]] = cell { x = i, y = 2, colour = if i == 0 then red else green, text = i }
draw cart = marker { x = cart.x, y = 0, colour = blue, heading = 0.5 }
draw at = rectangle { x = cart.at, y = 1, width = 1, height = 0.5, colour = sky, text = cart.side }
draw full = gauge { value = count(i in X where cart.ripe[i]), low = 0, high = 4, text = "full" }
draw note = label { x = 0, y = 3, text = "yard" }
"""


def model(drawn: str = DRAWN) -> ir.Model:
    return load("yard.pomdp", given=Source("yard.pomdp", MODEL + drawn)).model


def state(**changed: Any) -> dict[str, Any]:
    return {
        "cart.x": [1],
        "cart.at": [0.5],
        "cart.side": [1],
        "cart.ripe": [True, False, True, False],
    } | {f"cart.{name}": values for name, values in changed.items()}


def test_a_scene_has_an_extent_and_what_reads_no_variable() -> None:
    assert Scenes(model()).scene() == {
        "extent": {"cells": True, "x": [-1, 4], "y": [0, 3]},
        "static": [
            {"shape": "line", "name": "edge", "x": 0, "y": 0, "x2": 2.0, "y2": 0, "colour": "grey"},
            {"shape": "label", "name": "note", "colour": "black", "x": 0, "y": 3, "text": "yard"},
        ],
    }
    static = Scenes(model(), {"reach": 1.5}).scene()
    assert static is not None
    assert static["static"][0]["x2"] == 1.5


def test_a_model_without_drawings_has_no_scene() -> None:
    scenes = Scenes(model(""))
    assert scenes.scene() is None
    assert scenes.truth(state()) == []
    assert scenes.belief(state(), {"cart.side": [0, 1]})["belief"] == []


def test_gauges_alone_have_no_extent() -> None:
    scene = Scenes(model("draw x = gauge { value = cart.x, low = 0, high = 3 }")).scene()
    assert scene == {"extent": None, "static": []}


def test_the_extent_spans_the_ranges_of_all_places() -> None:
    scene = Scenes(model("draw a = marker { x = cart.x, y = 2 * cart.x - 1, colour = red }")).scene()
    assert scene is not None
    assert scene["extent"] == {"cells": False, "x": [0, 3], "y": [-1, 5]}


def test_a_state_is_drawn_for_each_member_that_fits() -> None:
    assert Scenes(model()).truth(state()) == [
        {"shape": "cell", "name": "ripe", "x": 0, "y": 2, "colour": "red", "text": "0"},
        {"shape": "cell", "name": "ripe", "x": 2, "y": 2, "colour": "green", "text": "2"},
        {"shape": "marker", "name": "cart", "x": 1, "y": 0, "colour": "blue", "heading": 0.5},
        {
            "shape": "rectangle", "name": "at", "x": 0.5, "y": 1, "width": 1, "height": 0.5,
            "colour": "sky", "text": "far",
        },
        {"shape": "gauge", "name": "full", "colour": "blue", "value": 2, "low": 0, "high": 4, "text": "full"},
    ]  # fmt: skip


@pytest.mark.parametrize(("side", "text"), [([0], "n"), (["near"], "n"), ("near", "n"), (["far"], "far")])
def test_values_may_be_codes_or_texts_and_show_their_glyphs(side: Any, text: str) -> None:
    shapes = Scenes(model()).truth(state(side=side))
    assert next(s for s in shapes if s["name"] == "at")["text"] == text


def test_what_is_no_number_is_not_drawn() -> None:
    assert "at" not in {s["name"] for s in Scenes(model()).truth(state(at=[None]))}


def test_equal_shapes_of_a_belief_are_one() -> None:
    ripe = [[True, False, True, False], [True, False, False, False], [True, True, False, False]]
    found = Scenes(model()).belief(state(), {"cart.ripe": ripe}, [2, 1, 1])
    cells = {s["text"]: s["p"] for s in found["belief"] if s["name"] == "ripe"}
    assert cells == {"0": 1.0, "1": 0.25, "2": 0.5}
    gauges = {s["value"]: s["p"] for s in found["belief"] if s["name"] == "full"}
    assert gauges == {1: 0.25, 2: 0.75}
    assert {s["name"] for s in found["belief"]} == {"ripe", "full"}, "the others read what was not sampled"
    assert found["belief_shown"] == found["belief_total"] == 5


def test_a_belief_is_cut_to_the_likeliest() -> None:
    count = MOST_SHAPES + 100
    sampled = {
        "cart.at": [0.0] * count + [i / count for i in range(1, count)],
        "cart.side": [1] * (2 * count - 1),
    }
    found = Scenes(model()).belief(state(), sampled)
    assert (found["belief_shown"], found["belief_total"]) == (MOST_SHAPES, count)
    assert found["belief"][-1]["p"] == max(s["p"] for s in found["belief"])


def test_drawings_do_not_change_the_hash() -> None:
    plain = model("").source_hash
    assert model(DRAWN).source_hash == plain
    assert model("\n\n" + DRAWN.replace("draw note", "\n\ndraw note")).source_hash == plain
    assert model("bound upper = 10").source_hash != plain


def test_colours_take_no_names_from_the_model() -> None:
    text = MODEL.replace("enum Act { wait, go }", "enum Act { wait, go, red }")
    drawn = "draw a = marker { x = cart.x, y = 0, colour = red }"
    own = load("yard.pomdp", given=Source("yard.pomdp", text + drawn)).model
    assert Scenes(own).truth(state())[0]["colour"] == "red"


@pytest.mark.parametrize(
    ("area", "cells"),
    [
        ("x = -1, y = 0, x2 = 4, y2 = 3", True),
        ("x = -0.5, y = 0, x2 = 4, y2 = 3", False),
        ("x = 0, y = 0, x2 = 399, y2 = 3", True),
        ("x = 0, y = 0, x2 = 400, y2 = 3", False),
        ("x = -2147483648, y = 0, x2 = 2147483647, y2 = 3", False),
    ],
)
def test_cells_are_few_and_whole(area: str, cells: bool) -> None:
    scene = Scenes(model(DRAWN.replace("x = -1, y = 0, x2 = 4, y2 = 3", area))).scene()
    assert scene is not None and scene["extent"]["cells"] == cells


def test_random_pictures_are_drawn(tmp_path: Path) -> None:
    drawn = 0
    for seed in range(8):
        path = tmp_path / "random.pomdp"
        path.write_text(str(random_model(seed)))
        try:
            found = load(path).model
        except ModelError:
            continue
        scenes, values = Scenes(found), Episode(found).values()
        samples = {v.name: [values[v.name]] * 3 for v in found.variables if not v.visible}
        if scenes.scene() is None:
            continue
        truth = scenes.truth(values)
        believed = scenes.belief(values, samples)["belief"]
        assert {shape["name"] for shape in believed} <= {shape["name"] for shape in truth}
        assert json.loads(json.dumps([truth, believed], allow_nan=False)) == [truth, believed]
        drawn += 1
    assert drawn > 2


EXAMPLES = sorted(
    p for p in [*ROOT.glob("examples/**/*.pomdp"), *ROOT.glob("benchmarks/models/*.pomdp")]
    if "\ndraw " in p.read_text()
)  # fmt: skip


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_draw_all_that_they_declare(path: Path) -> None:
    drawn = load(path).model
    scenes, episode = Scenes(drawn), Episode(drawn)
    scene = scenes.scene()
    assert scene is not None
    values = episode.values()
    shapes = scene["static"] + scenes.truth(values)
    samples = {v.name: [values[v.name]] * 3 for v in drawn.variables if not v.visible}
    believed = scenes.belief(values, samples)["belief"]
    hidden = {v.name for v in drawn.variables if not v.visible}
    assert {s["name"] for s in believed} == {
        s["name"] for s in shapes if next(d for d in drawn.drawings if d.name == s["name"]).reads & hidden
    }
    extent = scene["extent"]
    for shape in shapes if extent else ():
        for axis in "xy":
            if axis in shape:
                assert extent[axis][0] <= shape[axis] <= extent[axis][1], shape
