# SPDX-License-Identifier: Apache-2.0
"""Draws within draws: their words, and their densities against sums by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import ir_samples

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Frame
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.load import load
from hypgen.dsl.types import size_of

MODEL = """model Nested
type Cell = 0 .. 4
type Dir = 0 .. 3
record Pos {{ row, col: Cell }}
enum Act {{ wait, go(Dir), walk(Pos) }}
discount 0.9
action act: Act
fn step(c: Cell, d: Dir): Cell = if d == 0 then clamp(c + 1) else if d == 1 then clamp(c - 1) else c
fn near(c: Cell): Cell ~ {{ c: 0.75, else clamp(c + 1) }}
element robot {{
  hidden at: {type}
  init at ~ {draw}
  at' = at
}}
"""


def drawn(tmp_path: Path, draw: str, type_: str = "Cell") -> tuple[ir.Model, ir.Dist]:
    """Return a model whose init draws so, and the draw."""
    path = tmp_path / "m.pomdp"
    path.write_text(MODEL.format(draw=draw, type=type_))
    model = load(path).model
    return model, model.inits[0].dist


def law(model: ir.Model, dist: ir.Dist) -> list[float]:
    """Return the density of each value."""
    frame, evaluator = Frame(np.arange(1), {}), Evaluator(model, {})
    values = range(size_of(dist.type))
    return [float(np.max(evaluator.density(dist, frame, np.asarray(v, np.int32)))) for v in values]


@pytest.mark.parametrize(
    ("draw", "wanted", "words"),
    [
        ("{ 2: 0.5, else uniform(d in Dir: step(2, d)) }", [0, 0.125, 0.75, 0.125, 0], 2),
        ("{ uniform(Cell): 0.5, near(4): 0.25, else 0 }", [0.35, 0.1, 0.1, 0.1, 0.35], 2),
        ("step(2, uniform(Dir))", [0, 0.25, 0.5, 0.25, 0], 1),
        ("near(step(2, uniform(Dir)))", [0, 0.1875, 0.4375, 0.3125, 0.0625], 2),
        ("clamp(1 + uniform(Dir) - uniform(Dir))", [6 / 16, 4 / 16, 3 / 16, 2 / 16, 1 / 16], 2),
        ("if bernoulli(0.25) then 1 else near(2)", [0, 0.25, 0.5625, 0.1875, 0], 2),
        ("match near(0) { 0 => 3, else => uniform(Cell) }", [0.05, 0.05, 0.05, 0.8, 0.05], 2),
        ("let d ~ uniform(Dir) in if d > 1 then 4 else d", [0.25, 0.25, 0, 0, 0.5], 1),
        ("let d: Cell ~ noisy(1, 0.6) in clamp(2 * d)", [0.1, 0, 0.6, 0, 0.3], 1),
        ("let c: Cell = 3 in near(c)", [0, 0, 0, 0.75, 0.25], 1),
    ],
)
def test_laws(tmp_path: Path, draw: str, wanted: list[float], words: int) -> None:
    model, dist = drawn(tmp_path, draw)
    assert law(model, dist) == pytest.approx(wanted, abs=1e-7)
    assert words_of(dist) == words


def test_a_record_of_draws_is_their_product(tmp_path: Path) -> None:
    model, dist = drawn(tmp_path, "Pos(near(1), uniform(k in Cell where k > 2))", "Pos")
    wanted = np.zeros((5, 5))
    wanted[1, 3:] = 0.75 / 2
    wanted[2, 3:] = 0.25 / 2
    assert law(model, dist) == pytest.approx(wanted.reshape(-1).tolist(), abs=1e-7)


def test_variants_of_records(tmp_path: Path) -> None:
    model, dist = drawn(tmp_path, "{ go(uniform(Dir)): 0.5, else walk(Pos(0, near(0))) }", "Act")
    wanted = [0, 0.125, 0.125, 0.125, 0.125, 0.375, 0.125, *[0] * 23]
    assert law(model, dist) == pytest.approx(wanted, abs=1e-7)


def test_samplers_follow_the_law(tmp_path: Path) -> None:
    model, dist = drawn(tmp_path, "{ near(uniform(Cell)): 0.5, else clamp(uniform(Dir) + uniform(Dir)) }")
    lanes = 40_000
    words: Any = np.random.default_rng(1).integers(0, 2**32, (4, lanes))
    frame = Frame(np.arange(lanes), {})
    found = Evaluator(model, {}).sample(dist, frame, ir_samples.word(words[0], 0, *words[1:]))
    shares = np.bincount(found, minlength=5) / lanes
    assert shares.tolist() == pytest.approx(law(model, dist), abs=0.01)


def test_a_draw_that_nothing_reads_takes_no_word(tmp_path: Path) -> None:
    _, dist = drawn(tmp_path, "let d ~ uniform(Dir) in near(2)")
    assert words_of(dist) == 1
    assert isinstance(dist, ir.LetDist | ir.Table)
