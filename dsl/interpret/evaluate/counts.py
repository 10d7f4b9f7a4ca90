# SPDX-License-Identifier: Apache-2.0
"""Laws of counts: how many of a draw's 2^32 words give at most each count."""

from __future__ import annotations

from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.expressions import Expressions
from hypgen.dsl.interpret.evaluate.values import Array, Frame, Word, as_type
from hypgen.dsl.interpret.floats.exponentials import exp2_inside
from hypgen.dsl.types import Int

WORDS = np.uint64(2**32)
_MOST_MEAN = 690.0


def words_of(probability: Array) -> Array:
    """Return R(x): the number of words that a cumulative probability takes, rounded to nearest; 0 for NaN."""
    scaled = np.floor(np.asarray(probability) * 2.0**32 + 0.5)
    inside = np.where((scaled > 0.0) & (scaled < 2.0**32), scaled, 0.0).astype(np.uint64)
    return np.where(scaled >= 2.0**32, WORDS, inside)


def share(words: Array) -> Array:
    """Return the probability of that many words."""
    return np.asarray(words).astype(np.float64) * 2.0**-32


class Counts(Expressions):
    """Draws and densities of ``ir.Counted``."""

    def sample_count(self, dist: ir.Counted, frame: Frame, word: Word) -> Array:
        """Return a draw in each lane: the number of counts that the word has passed."""
        draw = word()
        low, reach = self._reach(dist, frame)
        passed: Any = sum(((draw >= words).astype(np.int64) for words in reach[:-1]), np.int64(0))
        shape = np.broadcast_shapes(np.shape(passed), draw.shape)  # one word may stand for all lanes
        return as_type(np.broadcast_to(passed + low, shape), dist.type)

    def density_of_count(self, dist: ir.Counted, frame: Frame, value: Array) -> Array:
        """Return the probability of ``value`` in each lane."""
        low, reach = self._reach(dist, frame)
        words: Any = np.uint64(0)
        before: Any = np.uint64(0)
        for k, after in enumerate(reach, low):
            words = np.where(value == k, after - before, words)
            before = after
        return share(words)

    def _reach(self, dist: ir.Counted, frame: Frame) -> tuple[int, list[Array]]:
        """Return the lowest count and, from there to the highest, how many words give at most each."""
        assert isinstance(dist.type, Int)
        low, high = dist.type.low, dist.type.high
        match dist:
            case ir.Poisson():
                reach = self._poisson(dist, frame, high)
            case ir.Binomial():
                reach = self._binomial(dist, frame, low, high)
            case _:
                raise TypeError(f"unknown law of counts {type(dist).__name__}")
        return low, [*reach[low:high], np.asarray(WORDS)]

    def _poisson(self, dist: ir.Poisson, frame: Frame, high: int) -> list[Array]:
        given = self.value(dist.mean, frame).astype(np.float64)
        mean = np.where(given > 0.0, np.minimum(given, _MOST_MEAN), 0.0)
        masses = [exp2_inside(mean * -1.4426950408889634)]
        for k in range(1, max(high, dist.last or 0) + 1):
            masses.append(masses[-1] * (mean / k))
        first, last = np.asarray(dist.first), np.asarray(high if dist.last is None else dist.last)
        sums = _sums(masses, first, last)
        total = 1.0 if dist.last is None else sums[-1]
        return [words_of(s / total) for s in sums]

    def _binomial(self, dist: ir.Binomial, frame: Frame, low: int, high: int) -> list[Array]:
        trials = self.value(dist.trials, frame).astype(np.int64)
        given = self.value(dist.probability, frame).astype(np.float64)
        p = np.where(given > 0.0, np.minimum(given, 1.0), 0.0)
        failures = p > 0.5
        p = np.where(failures, 1.0 - p, p)
        most = int(np.max(trials, initial=0))
        masses = [_power(1.0 - p, trials)]
        odds = p / (1.0 - p)
        for k in range(max(most, high)):
            masses.append((masses[-1] * ((trials - k) / (k + 1.0))) * odds)
        first, last = np.asarray(0), trials
        if dist.last is not None:
            first = np.where(failures, trials - dist.last, dist.first)
            last = np.where(failures, trials - dist.first, dist.last)
        sums = _sums(masses, first, last)
        total = 1.0 if dist.last is None else sums[-1]
        reach = np.stack(np.broadcast_arrays(np.uint64(0), *(words_of(s / total) for s in sums)))
        result = []
        for k in range(high):
            place = np.where(failures, np.clip(trials - k, 0, len(sums)), k + 1)
            words = np.take_along_axis(reach, np.broadcast_to(place, reach.shape[1:])[np.newaxis], axis=0)[0]
            words = np.where(failures, WORDS - words, words)
            result.append(np.where((k >= trials) | (trials <= low), WORDS, words))
        return result


def _sums(masses: list[Array], first: Array, last: Array) -> list[Array]:
    """Return the running sums of those masses whose count lies in first .. last."""
    sums: list[Array] = []
    total: Array = np.zeros(())
    for k, mass in enumerate(masses):
        total = np.where((k >= first) & (k <= last), total + mass, total)
        sums.append(total)
    return sums


def _power(base: Array, exponent: Array) -> Array:
    """Return base^exponent by squaring, from the exponent's lowest bit."""
    result: Array = np.ones(())
    left = np.maximum(exponent, 0)
    while np.any(left > 0):
        result = np.where(left & 1, result * base, result)
        base = base * base
        left = left >> 1
    return result
