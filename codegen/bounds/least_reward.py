# SPDX-License-Identifier: Apache-2.0
"""The least that a step can earn, from the intervals of the reward terms."""

from __future__ import annotations

import math
import struct

from hypgen.dsl import ir
from hypgen.dsl.types import Float, Int, size_of

_SLACK = 1e-6  # of rounding, relative to the sum of the terms' sizes


def least_reward(model: ir.Model) -> float | None:
    """Return a lower bound on the reward of any step, None where a term has none.

    The sum is made lower by what rounding to float32 and to fixed point could add.
    """
    total = size = 0.0
    for reward in model.rewards:
        low = _low(reward.value)
        if math.isinf(low) or math.isnan(low):
            return None
        members = 1 if reward.binder is None else size_of(reward.binder.type)
        total += members * low
        size += members * abs(low)
    rounded: float = struct.unpack(
        "<f", struct.pack("<f", total - _SLACK * (size + 2.0 ** (ir.REWARD_BITS - model.reward_bits)))
    )[0]
    return rounded


def _low(value: ir.Expr) -> float:
    match value.type:
        case Int(low, _):
            return float(low)
        case Float(low, _):
            return low
    return 0.0
