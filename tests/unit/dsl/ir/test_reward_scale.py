# SPDX-License-Identifier: Apache-2.0
"""The fixed point of rewards follows from what they can be."""

from __future__ import annotations

import math

import pytest

from hypgen.dsl import ir
from hypgen.dsl.ir.reward_scale import largest_return, largest_reward
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

FRAME = """
model Scales
type Cell = 0 .. 3
enum Act {{ a, b }}
discount {discount}
action act: Act
param fee: float = 5.0
fn twice(x: float): float = x + x
fn share(x: Cell): prob = fee * x
element bot {{
  visible at: Cell
  hidden level: float
  init at = 0
  init level = 0.0
  at' = at
  level' = level
}}
{rewards}
bound upper = 1e30
bound tail = 0.0
"""


def model(*rewards: str, discount: float = 0.5) -> ir.Model:
    terms = "\n".join(f"reward r{i} = {text}" for i, text in enumerate(rewards))
    source = Source("m.pomdp", FRAME.format(rewards=terms, discount=discount))
    return lower(parse(source), {}, source)


@pytest.mark.parametrize(
    ("rewards", "bits"),
    [
        (("1.0",), 24),
        (("0",), 24),
        (("8388607.0",), 24),
        (("8388608.0",), 23),
        (("2.5e7",), 22),
        (("1e30",), 48 - 101),
        (("0.5",), 25),
        (("2e-8",), 24 + 26),
        (("1e-40",), 24 + 133),
        (("1e9", "-1e9"), 48 - 32),
        (("1e-9", "100.0"), 24),
        (("-fee",), 24),
        (("fee * 1e-9",), 24 + 28),
        (("if act == a then twice(fee) * 1e7 else -1.0",), 48 - 28),
        (("bot.level'",), 24),
        (("clamp(bot.level', -1e9, 0.0)",), 48 - 31),
    ],
)
def test_bits_keep_the_largest_reward_and_make_room_for_the_sum(rewards: tuple[str, ...], bits: int) -> None:
    found = model(*rewards)
    assert found.reward_bits == bits
    step, most = largest_reward(found), largest_return(found)
    if 0.0 < step < math.inf:
        assert most * 2.0**bits < 2.0**48
        assert step * 2.0**bits >= 2.0**24


def test_a_long_horizon_takes_bits_of_a_step() -> None:
    assert model("1.0", discount=0.9999999).reward_bits == 24
    assert model("1.0", discount=0.99999999).reward_bits == 48 - 27


@pytest.mark.parametrize(
    ("reward", "fits"),
    [
        ("if act == a then 1.0 else -8e6", True),
        ("clamp(bot.level', -1e9, 0.0)", True),
        ("1.0 * bot.at", True),
        ("bot.level'", False),
        ("fee", False),  # a file may give it any value
        ("share(bot.at)", False),  # nothing keeps it a probability
        ("1.0 * bot.at * 1e30 * 1e30 * 1e-30 * 1e-30", False),  # infinite on the way
    ],
)
def test_rewards_fit_where_nothing_takes_them_out_of_range(reward: str, fits: bool) -> None:
    assert model(reward).rewards_fit == fits
