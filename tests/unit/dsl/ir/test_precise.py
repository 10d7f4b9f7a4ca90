# SPDX-License-Identifier: Apache-2.0
"""Draws from constant arrays get the probabilities that their texts say."""

from __future__ import annotations

from fractions import Fraction

import pytest

from hypgen.dsl import ir
from hypgen.dsl.ir import masses
from hypgen.dsl.ir.precise import with_precise_draws
from hypgen.dsl.ir.rounding import rounding
from hypgen.dsl.ir.walk import walk
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

FRAME = """
model Precise
type Place = 0 .. 2
type Row = 0 .. 3
enum Act { a, b }
discount 0.5
action act: Act
const row_of: Row[Act, Place] = "0 1 2 3 1 0"
const weight: float[Row, Place] = ["0.1 0.2 0.7 0.3 0.3 0.4", "0 0.1 0.9 1 2 4"]
const first: 0 .. 3[Row] = "0 2 2 3"
const size: 1 .. 2[Row] = "2 1 1 2"
const chance: prob[0 .. 4] = "0.1 0.9 1e-9 0.3 0.7"
const heard: prob[Place] = [0.85, 0.1, 1e-10]
PARTS
element robot {
  hidden at: Place
  init at ~ uniform(Place)
  at' ~ DRAW
}
observe side: bool ~ bernoulli(heard[robot.at'])
reward gain = if act == a then 1 else 0
bound upper = 10
bound tail = 0.0
"""
BY_ROW = "fn by(r: Row): Place ~ weighted(v in Place: weight[r, v])"
BY_ENTRY = """fn by(r: Row): Place ~
  let k = first[r] in if size[r] == 1 then 1 else { 0: chance[k], else 2 }"""


def model(draw: str, parts: str = "") -> ir.Model:
    source = Source("m.pomdp", FRAME.replace("DRAW", draw).replace("PARTS", parts))
    return with_precise_draws(lower(parse(source), {}, source))


def tables(found: ir.Model) -> list[list[Fraction]]:
    """Return the probabilities of all draws of the robot's place."""
    return [
        [Fraction(m, masses.WHOLE) for m in masses.of_table(d) or ()]
        for d in walk(found.updates[0].dist)
        if isinstance(d, ir.Table)
    ]


@pytest.mark.parametrize(
    ("draw", "parts"),
    [
        ("weighted(v in Place: weight[row_of[act, robot.at], v])", ""),
        ("by(row_of[act, robot.at])", BY_ROW),
    ],
)
def test_rows_of_weights_are_shares_of_their_sum(draw: str, parts: str) -> None:
    found = tables(model(draw, parts))
    said = [[1, 2, 7], [3, 3, 4], [1, 9], [1, 2, 4]]
    for row, weights in zip(found, said, strict=True):
        for share, weight in zip(row, weights, strict=True):
            assert abs(share - Fraction(weight, sum(weights))) <= Fraction(len(row), masses.WHOLE)
    assert rounding(model(draw, parts)).step < 1e-17


def test_weights_below_0_count_as_none() -> None:
    source = FRAME.replace("0.1 0.2 0.7 0.3 0.3 0.4", "-1 1 2 -3 1 1").replace(
        "DRAW", "by(row_of[act, robot.at])"
    )
    parsed = Source("m.pomdp", source.replace("PARTS", BY_ROW))
    found = tables(with_precise_draws(lower(parse(parsed), {}, parsed)))
    assert [[round(float(p), 9) for p in row] for row in found[:2]] == [
        [0.333333333, 0.666666667],
        [0.5, 0.5],
    ]


def test_only_rows_that_reach_a_draw_are_written_out() -> None:
    found = tables(model("by(row_of[act, robot.at])", BY_ENTRY))
    assert [round(float(row[0]), 6) for row in found] == [0.1, 0.3]  # of rows 0 and 3, not of row 2's 1e-9
    assert rounding(model("by(row_of[act, robot.at])", BY_ENTRY)).step < 1e-17


def test_a_number_from_an_array_is_as_rare_as_it_says() -> None:
    draws = [d for d in walk(model("uniform(Place)").observations[0].dist) if isinstance(d, ir.Bernoulli)]
    assert [masses.of_constant(d.probability) for d in draws if isinstance(d.probability, ir.Const)] == [
        round(Fraction(p) * masses.WHOLE) for p in ("0.85", "0.1", "1e-10")
    ]


def test_what_is_computed_stays_as_it_is() -> None:
    text = "weighted(v in Place: weight[row_of[act, robot.at], v] * 2.0)"
    assert any(isinstance(d, ir.Weighted) for d in walk(model(text).updates[0].dist))
