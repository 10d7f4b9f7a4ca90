# SPDX-License-Identifier: Apache-2.0
"""Samples of what exact posteriors say of hidden variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, from_position
from hypgen.dsl.types import length_of, size_of


def factor_samples(
    model: ir.Model, posterior: Mapping[str, Sequence[Sequence[float]]], count: int
) -> dict[str, Array]:
    """Return samples of each variable in an exact factor: samples by entries, row-major.

    ``posterior`` has the probabilities of each member's joint values by factor, as ``Episode.belief`` gives
    them. Each value has its share of the samples, up to one. Members are sampled apart, always alike.
    """
    result: dict[str, Array] = {}
    random = np.random.default_rng(0)
    levels = (np.arange(count) + 0.5) / count
    for factor in model.factors:
        members = [
            random.permutation(np.searchsorted(np.cumsum(chances) / sum(chances), levels))
            for chances in posterior.get(factor.element, ())
            if sum(chances) > 0
        ]
        if not members:
            continue
        codes = np.stack(members, axis=1)
        for variable in map(model.variable, reversed(factor.variables)):
            length = length_of(variable.indices) // (1 if factor.binder is None else len(members))
            entries = []
            for _ in range(length):
                codes, digit = np.divmod(codes, size_of(variable.type))
                entries.append(from_position(digit, variable.type))
            result[variable.name] = np.stack(entries[::-1], axis=2).reshape(count, -1)
    return result
