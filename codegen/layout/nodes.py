# SPDX-License-Identifier: Apache-2.0
"""The nodes that code generation adds to the IR.

``history_layout`` and ``tabulate`` put them in the place of the model's own; printers and analyses know them
beside the others.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from hypgen.dsl import ir

POSITION = "entry%"  # the local in a pick's values; no local of the model is called so
WORDS = 1 << 32  # the values of a random word


@dataclass(frozen=True)
class HistoryRead(ir.Expr):
    """A field of the history, as it is before the decision."""

    field: str
    indices: tuple[ir.Expr, ...] = ()


@dataclass(frozen=True)
class BeliefCall(ir.Expr):
    """The mean that the function of a ``BeliefRead`` gives: of its number, called with its free locals."""

    number: int
    arguments: tuple[ir.Expr, ...]


@dataclass(frozen=True)
class ArrayBits(ir.Expr):
    """All entries of a state variable as they lie in its word, the first entry lowest."""

    variable: str


@dataclass(frozen=True)
class WeightedPick(ir.Dist):
    """``value`` at a ``POSITION`` drawn by constant probabilities; the last position takes the rest."""

    probabilities: tuple[ir.Const, ...]
    value: ir.Expr

    def bounds(self) -> tuple[int, ...]:
        """Return for each position but the last how many words lie before its end."""
        result, total = [], 0
        for probability in self.probabilities:
            total += _threshold(float(probability.value))
            result.append(min(total, WORDS))
        return tuple(result)


@dataclass(frozen=True)
class UniformPick(ir.Dist):
    """``value`` at any ``POSITION`` below ``count``, which is at least 1, equally likely."""

    count: ir.Expr
    value: ir.Expr


def _threshold(probability: float) -> int:
    """Return ``math::threshold`` of a float32: how many words lie below a probability."""
    scaled = struct.unpack("<f", struct.pack("<f", probability))[0] * WORDS
    return 0 if not scaled > 0 else min(int(min(scaled, WORDS)), WORDS)
