# SPDX-License-Identifier: Apache-2.0
"""Probabilities as masses, in units of 2^-63 and in each lane."""

from __future__ import annotations

from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.expressions import Expressions
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.interpret.floats.scalar_functions import WHOLE, after
from hypgen.dsl.interpret.floats.scalar_functions import mass as mass_of
from hypgen.dsl.ir import masses

_RARE = np.uint64(masses.RARE)


class Masses(Expressions):
    """The masses of probabilities."""

    def mass(self, probability: ir.Expr, complement: ir.Expr | None, frame: Frame) -> Array:
        """Return the mass of a probability in each lane."""
        if isinstance(probability, ir.Const):
            return np.asarray(np.uint64(masses.of_constant(probability)))
        result = mass_of(self.value(probability, frame))
        if complement is None:
            return result
        lacking = self.value(complement, frame)
        return np.where(lacking < np.float32(2.0**-9), WHOLE - mass_of(lacking), result)

    def masses(self, dist: ir.Table, frame: Frame) -> list[Array]:
        """Return the masses of all entries but the last value, which takes what they leave."""
        constant = masses.of_table(dist)
        if constant is not None:
            return [np.asarray(np.uint64(m)) for m in constant[:-1]]
        complements = dist.complements or (None,) * len(dist.entries)
        found = [
            self.mass(p, lacking, frame) for (_, p), lacking in zip(dist.entries, complements, strict=True)
        ]
        return found if dist.rest is not None else _settled(found)[:-1]


def _settled(found: list[Array]) -> list[Array]:
    """Return masses of which, where the last is rare, the likeliest gets what the others leave."""
    largest, place = found[0], np.zeros((), dtype=np.int64)
    for number, mass in enumerate(found):
        place = np.where(mass > largest, number, place)
        largest = np.maximum(mass, largest)
    others: Any = np.uint64(0)
    for number, mass in enumerate(found):
        others = np.where(place == number, others, after(others, mass))
    rare = found[-1] < _RARE
    return [np.where(rare & (place == n), WHOLE - others, mass) for n, mass in enumerate(found)]
