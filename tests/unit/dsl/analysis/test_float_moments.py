# SPDX-License-Identifier: Apache-2.0
"""Which floats a policy may know by mean and deviation, and why not others."""

from __future__ import annotations

import pytest

from hypgen.dsl import ir
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

HEAD = """model Floats
discount 0.9
action act: 1 .. 3
param reach: float = 5
reward none = 0
element robot { visible at: 0 .. 5  init at = 2  at' = at }
"""
STILL = {
    "a float that keeps its value": "element a { hidden x: float  init x ~ normal(0.0, 1.0)  x' = x }",
    "a fixed float": "element a { hidden fixed x: float  init x ~ exponential(2.0) }",
    "a family": "element a[i in 0 .. 3] { hidden x: float  init x ~ normal(0.0, 1.0)  x' = x }",
    "an unknown range": "element a { hidden fixed x: float  init x ~ uniform(0.0, 1.0 + robot.at) }",
}
MOVES = {
    "noise": "element a { hidden x: float  init x = 0  x' ~ if act == 1 then normal(0.5 * x, 1.0) else x }",
    "a uniform step": "element a { hidden x: float  init x ~ uniform(0.0, 1.0)  x' ~ uniform(x - 1, x + 1) }",
    "a table": "element a { hidden x: float  init x = 0  x' ~ { x: 0.5, else x + 1 } }",
}
RANGES = {
    "a uniform start": "element a { hidden fixed x: float  init x ~ uniform(-1.0, 2 * reach) }",
    "a family's": "element a[i in 0 .. 3] { hidden x: float  init x ~ uniform(0.0, reach + i)  x' = x }",
    "a probability": "element a { hidden x: prob  init x = 0.5  x' = clamp(x + 0.1, 0, 1) }",
}
REFUSED = {
    "'a.x' and 'a.v' may depend on each other": (
        "hidden x, v: float  init x = 0  init v = 1  x' = x + v  v' = v"
    ),
    "'a.x' is an array": "hidden x: float[0 .. 2]  init x = [i in 0 .. 2: 1.0]  x' = [i in 0 .. 2: x[i]]",
    "the init of 'a.x' draws from 'truncated(..)'": (
        "hidden x: float  init x ~ truncated(normal(0.0, 1.0), 0.0, 1.0)  x' = x"
    ),
    "the update of 'a.x' draws from 'clamp(..)'": (
        "hidden x: float  init x = 0  x' ~ if act == 1 then clamp(normal(x, 1.0), 0.0, 9.0) else x"
    ),
    "the draw 'a.gust' is read": "hidden x: float  init x = 0  let gust ~ normal(0.0, 1.0)  x' = x + gust",
    "'observe high' reads 'a.x' as it was before the step": (
        "hidden x: float  init x = 0  x' ~ normal(x, 1.0)  observe high: bool ~ noisy(x > 0, 0.9)"
    ),
}


@pytest.mark.parametrize("text", STILL.values(), ids=STILL)
def test_what_stands_still_has_the_normal_law_of_its_moments(text: str) -> None:
    assert factor_of(text).moments == ir.Moments("a.x", True, None)


@pytest.mark.parametrize("text", MOVES.values(), ids=MOVES)
def test_what_moves_has_the_normal_law_of_its_moments(text: str) -> None:
    assert factor_of(text).moments == ir.Moments("a.x", False, None)


@pytest.mark.parametrize("text", RANGES.values(), ids=RANGES)
def test_what_never_leaves_a_range_has_its_beta_law(text: str) -> None:
    moments = factor_of(text).moments
    assert moments is not None and moments.ends is not None


@pytest.mark.parametrize("reason", REFUSED)
def test_a_reason_is_given_for_other_floats(reason: str) -> None:
    factor = factor_of(f"element a {{ {REFUSED[reason]} }}")
    assert (factor.moments, factor.unmatched) == (None, reason)


def test_a_terminal_condition_on_the_state_before_the_step_is_a_reason_too() -> None:
    text = "element a { hidden x: float  init x = 0  x' ~ normal(x, 1.0) }\nterminal when a.x > 3"
    assert factor_of(text).unmatched == "'terminal when' reads 'a.x' as it was before the step"


def factor_of(text: str) -> ir.Factor:
    source = Source("m.pomdp", HEAD + text)
    (factor,) = lower(parse(source), {}, source).factors
    return factor
