# SPDX-License-Identifier: Apache-2.0
"""What is rounded of a model's text is bounded, and what is exact counts as exact."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hypgen.dsl.ir.rounding import Rounding, rounding
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

FRAME = """
model Rounded
enum Act {{ a, b }}
discount 0.5
action act: Act
param fee: float = 0.1
param hearing: prob = 0.85
element coin {{
  hidden heads: bool
  init heads ~ bernoulli(0.5)
  heads' ~ bernoulli({p})
}}
observe side: bool ~ noisy(coin.heads', {q})
reward gain = {reward}
bound upper = 1e6
bound tail = 0.0
"""


def found(p: str = "0.25", q: str = "0.5", reward: str = "1") -> Rounding:
    source = Source("m.pomdp", FRAME.format(p=p, q=q, reward=reward))
    return rounding(lower(parse(source), {}, source))


def off(text: str) -> float:
    return float(abs(Fraction(text) - Fraction(float(np.float32(text)))))


def test_dyadic_numbers_are_exact() -> None:
    exact = found(reward="if act == a then -100 else 10")
    assert exact.reward == 0.0 and exact.start == 0.0
    assert exact.step < 2.0**-58 and exact.drawn == 0.0 and exact.whole == 200.0


@pytest.mark.parametrize("text", ["0.1", "-0.3", "1e-9", "123456.7", "0.1 + 0.2", "1.0 / 3.0"])
def test_a_rounded_literal_is_as_far_from_its_text_as_it_is(text: str) -> None:
    exact = Fraction(1, 3) if "/" in text else sum(map(Fraction, text.split(" + ")), Fraction(0))
    bound = found(reward=text).reward
    assert float(abs(exact - Fraction(float(np.float32(float(exact)))))) <= bound
    assert bound <= 2.0**-23 * max(abs(float(exact)), 2.0**-1) + 2.0**-25


@pytest.mark.parametrize("text", ["fee", "-2.0 * fee", "fee ^ 2", "clamp(fee, 0.0, 5.0)"])
def test_what_is_computed_of_a_param_has_a_bound(text: str) -> None:
    assert off("0.1") <= found(reward=text.replace("^", "**")).reward < 1e-6


def test_probabilities_count_twice() -> None:
    assert 2 * off("0.3") <= found(p="0.3").step < 3 * off("0.3") + 2.0**-58
    assert 2 * off("0.85") <= found(q="hearing").step < 2.1 * 2.0**-24
    assert found(q="hearing").lost < 2.0**-58 < found(q="1.0 - fee * fee * fee").lost


def test_an_unlimited_reward_has_no_bound() -> None:
    assert found(reward="1.0 / (fee - 0.1)").reward > 1.0
