# SPDX-License-Identifier: Apache-2.0
"""Bounds that nobody declares: what they are where rewards read params, which a solver knows at its start."""

from pathlib import Path

import numpy as np
import pytest

from hypgen.dsl import load
from hypgen.dsl.interpret.floats.philox import PhiloxDraws
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.messages.diagnostic import ModelError

MODEL = """model M
enum Act { wait, go }
type Cell = 0 .. 3
action act: Act
discount 0.5
param gain: float = 8
param cost: float = 2
param scale: float = 4
param prize: float[Cell] = [1, 6, -3, 2]
record Vec { x, y: float }
record Deed { what: Act  at: Cell }
param goal: Vec = Vec(3, 4)
const spots: Vec[Cell] = [c in Cell: Vec(3 * c, 4 * c)]
fn far(v: Vec): float = hypot(v.x, v.y)
fn turned(v: Vec): Vec = Vec(v.y, -v.x)
fn level(x: float): float = log(x)
fn worth(x: Cell, g: float): float = if x > 1 then g * x else -g
element cart {
  visible at: Cell
  hidden x: float
  init at = 0
  init x = 0.0
  at' = if act == go then clamp(at + 1) else at
  x' = x + 1.0
}
element lamp[c in Cell] {
  hidden lit: bool
  init lit = false
  lit' = lit or act == go
  FAMILY
}
REWARD
"""


def bounds(tmp_path: Path, reward: str, family: str = "") -> tuple[float, float]:
    path = tmp_path / "m.pomdp"
    path.write_text(MODEL.replace("REWARD", reward).replace("FAMILY", family))
    run = Interpreter(load.load(path).model, lanes=1)
    draws = PhiloxDraws((0, 0), np.arange(1), 0)
    state = run.init_hidden(run.init_visible(draws), draws)
    return float(run.upper(state)[0]), float(run.tail(state)[0])


@pytest.mark.parametrize(
    ("reward", "least", "most"),  # of a step
    [
        ("if act == go then gain else -cost", -2, 8),
        ("gain - 2 * cost + 1", 5, 5),
        ("if act == go then prize[cart.at] else 0.5", -3, 6),
        ("prize[1] * cart.at", 0, 18),
        ("cart.at / scale", 0, 0.75),
        ("worth(cart.at, gain)", -8, 24),
        ("abs(gain - cart.at * cost)", 0, 8),
        ("sum(c in Cell where lamp[c].lit: prize[c])", -3, 9),
        ("max(c in Cell: prize[c] - cost)", 4, 4),
        ("min(prize[cart.at], clamp(cart.x, 0, 4))", -3, 4),
        ("if gain > cost then gain else cart.at", 8, 8),
        ("let k = gain * 0.5 in k * cart.at", 0, 12),
        ("sqrt(gain / 2) * cart.at", 0, 6),
        ("if act == go then far(goal) else -1", -1, 5),
        ("-far(Vec(goal.x - 3, cart.at))", -3, 0),
        ("(cost / 4) ** cart.at", 0.125, 1),
        ("let done = Deed(act, cart.at) in match done.what { go => prize[done.at]  wait => -cost }", -3, 6),
        ("if act == go then far(Vec(6.0, 8.0)) else 0", 0, 10),
        ("turned(turned(Vec(1.0, 2.0))).y", -2, -2),
        ("-far(spots[cart.at])", -15, 0),
        ("level(1 + cart.at) * 0 + level(cost / 2)", 0, 0),
    ],
)
def test_what_is_known_at_the_start_counts(reward: str, least: float, most: float, tmp_path: Path) -> None:
    upper, tail = bounds(tmp_path, f"reward r = {reward}")
    assert upper == pytest.approx(2 * most, rel=1e-5, abs=1e-5) and upper >= 2 * most
    assert tail == pytest.approx(2 * least, rel=1e-5, abs=1e-5) and tail <= 2 * least


def test_all_members_and_terms_count(tmp_path: Path) -> None:
    upper, tail = bounds(
        tmp_path, "reward r = if act == go then 1 else 0", "reward lit = if lit' then prize[c] else 0"
    )
    assert upper == pytest.approx(2 * (9 + 1), rel=1e-5)
    assert tail == pytest.approx(2 * -3, rel=1e-5)


def test_an_end_limits_what_is_lost(tmp_path: Path) -> None:
    upper, _ = bounds(tmp_path, "reward r = -gain\nterminal when cart.at == 3")
    assert upper == 0.0


@pytest.mark.parametrize(
    "reward", ["cart.x", "gain * cart.x", "gain / (cart.at - cost)", "far(Vec(cart.x, gain)) - cart.x"]
)
def test_what_nothing_limits_is_asked_for(reward: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        bounds(tmp_path, f"reward r = {reward}")
    assert [d.code for d in caught.value.diagnostics] == ["E0607"]
    assert "bound upper and bound tail" in caught.value.diagnostics[0].message


def test_one_bound_alone_may_be_lacking(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        bounds(tmp_path, "reward r = -level(cart.at)")
    assert "bound upper cannot be derived" in caught.value.diagnostics[0].message


@pytest.mark.parametrize(("call", "code"), [("level(0)", "E0612"), ("level(1 - cart.at // 4 - 1)", "E0607")])
def test_a_call_without_a_value_is_told_where_it_has_none(call: str, code: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        bounds(tmp_path, f"reward r = if act == go then {call} else 0")
    assert [d.code for d in caught.value.diagnostics] == [code]


@pytest.mark.parametrize("value", ["log(c)", "level(c)", "2 * level(c)", "gain * level(c)", "sqrt(c - 1)"])
def test_a_member_without_a_value_leaves_the_family_unlimited(value: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        bounds(tmp_path, "reward r = 0", f"reward lit = {value}")
    assert [d.code for d in caught.value.diagnostics] == ["E0607"]


def test_bounds_are_asked_for_together_with_other_mistakes(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        bounds(tmp_path, "reward r = cart.x\nterminal when cart.att == 3")
    assert [d.code for d in caught.value.diagnostics] == ["E0607", "E0205"]
