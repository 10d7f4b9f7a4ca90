# SPDX-License-Identifier: Apache-2.0
"""Continuous laws: a draw from one word, the probability below a value, and the density of a value.

Probabilities are float64. Where a law degenerates (no width, no probability between the ends), comparisons
say so and lanes hold infinities and NaN on the way.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.counts import Counts, share, words_of
from hypgen.dsl.interpret.evaluate.values import Array, Frame, Word, as_type
from hypgen.dsl.interpret.floats import scalar_functions
from hypgen.dsl.interpret.floats.exponentials import exp2_inside, log_double
from hypgen.dsl.interpret.floats.normal import (
    exponential_of_word,
    normal_cdf,
    normal_of_word,
    normal_quantile,
    unit_of_word,
)
from hypgen.dsl.types import low_of, size_of

Below = Callable[[Array], Array]

_PEAK = 0.3989422804014327  # 1 / sqrt(2 pi)


class ContinuousLaws(Counts):
    """Draws and densities of ``ir.Continuous`` and ``ir.Binned``."""

    def sample_continuous(self, law: ir.Continuous, frame: Frame, word: Word) -> Array:
        """Return a draw in each lane."""
        match law:
            case ir.Normal():
                z = normal_of_word(word()).astype(np.float32)
                return np.asarray(self.value(law.mean, frame) + self.value(law.deviation, frame) * z)
            case ir.UniformFloat():
                low, high = self.value(law.low, frame), self.value(law.high, frame)
                u = unit_of_word(word()).astype(np.float32)
                return scalar_functions.minimum(low + (high - low) * u, high)
            case ir.Exponential():
                return np.asarray(self._mean(law, frame) * exponential_of_word(word()).astype(np.float32))
            case ir.Truncated():
                return self._sample_truncated(law, frame, word)
            case ir.Clamped():
                drawn = self.sample_continuous(law.law, frame, word)
                return scalar_functions.clamp(drawn, as_type(law.low, law.type), as_type(law.high, law.type))
        raise TypeError(f"unknown law {type(law).__name__}")

    def _mean(self, law: ir.Exponential, frame: Frame) -> Array:
        mean = self.value(law.mean, frame)
        return np.where(mean > 0.0, mean, np.float32(0.0))

    def below(self, law: ir.Continuous, frame: Frame) -> Below:
        """Return the function that gives the probability below a double."""
        match law:
            case ir.Normal():
                mean, deviation = self._doubles(frame, law.mean, law.deviation)
                return lambda x: normal_cdf((x - mean) / np.abs(deviation))
            case ir.UniformFloat():
                return partial(_below_uniform, *self._doubles(frame, law.low, law.high))
            case ir.Exponential():
                size = self._mean(law, frame).astype(np.float64)
                return lambda x: 1.0 - _survival(x, size)
            case ir.Truncated():
                return self._below_truncated(law, frame)
        raise TypeError(f"no probabilities of {type(law).__name__}")

    def _doubles(self, frame: Frame, *values: ir.Expr) -> tuple[Array, ...]:
        return tuple(self.value(e, frame).astype(np.float64) for e in values)

    # Truncated laws ----------------------------------------------------------------------------

    def _sample_truncated(self, law: ir.Truncated, frame: Frame, word: Word) -> Array:
        low, high = self.value(law.low, frame), self.value(law.high, frame)
        start, end = low.astype(np.float64), high.astype(np.float64)
        p = unit_of_word(word())
        match law.law:
            case ir.Normal(_, mean_, deviation_):
                mean, scale = self.value(mean_, frame), np.abs(self.value(deviation_, frame))
                center, size = mean.astype(np.float64), scale.astype(np.float64)
                total = _between_normal(center, size, start, end)
                a, p = (start - center) / size, p * total
                z = normal_quantile(np.where(a > 0.0, normal_cdf(-a) - p, normal_cdf(a) + p))
                distance = scale * z.astype(np.float32)
                x = np.where(a > 0.0, mean - distance, mean + distance)
            case ir.Exponential():
                mean, center = self._mean(law.law, frame), np.zeros(())
                size = mean.astype(np.float64)
                total = _survival(start, size) - _survival(end, size)
                x = mean * (-log_double(_survival(start, size) - p * total)).astype(np.float32)
            case _:
                raise TypeError(f"{type(law.law).__name__} is not truncated")
        inside = np.where(x > low, np.where(high < x, high, x), low)
        return np.where(total > 0.0, inside, np.where(center < start, low, high))

    def _between(self, law: ir.Truncated, frame: Frame, low: Array) -> tuple[Below, Array]:
        """Return the law's probability from ``low`` to a double, and the law's middle."""
        match law.law:
            case ir.Normal(_, mean, deviation):
                center, size = self._doubles(frame, mean, deviation)
                return partial(_between_normal, center, np.abs(size), low), center
            case ir.Exponential():
                size = self._mean(law.law, frame).astype(np.float64)
                return partial(_between_exponential, size, low), np.zeros(())
        raise TypeError(f"{type(law.law).__name__} is not truncated")

    def _total(self, law: ir.Truncated, frame: Frame) -> Array:
        """Return the law's probability between the ends."""
        low, high = self._doubles(frame, law.low, law.high)
        return self._between(law, frame, low)[0](high)

    def _below_truncated(self, law: ir.Truncated, frame: Frame) -> Below:
        low, high = self._doubles(frame, law.low, law.high)
        between, center = self._between(law, frame, low)
        total = between(high)
        nearer = np.where(center < low, low, high)

        def below(x: Array) -> Array:
            part = np.where(x > low, np.where(x < high, between(x) / total, 1.0), 0.0)
            return np.where(total > 0.0, part, np.where(x > nearer, 1.0, 0.0))

        return below

    # Densities ---------------------------------------------------------------------------------

    def density_of_law(self, law: ir.Continuous, frame: Frame, value: Array) -> Array:
        """Return the density of ``value`` in each lane; at a point, its probability."""
        if isinstance(law, ir.Clamped):
            return self._clamped_density(law, frame, value)
        is_point, point = self._point(law, frame)
        spread = self._spread_of(law, frame, value.astype(np.float64))
        return np.where(is_point, np.where(value == point, 1.0, 0.0), spread)

    def _clamped_density(self, law: ir.Clamped, frame: Frame, value: Array) -> Array:
        is_point, point = self._point(law.law, frame)
        low, high = as_type(law.low, law.type), as_type(law.high, law.type)
        spread = self._spread_of(law.law, frame, value.astype(np.float64))
        inside = np.where((value > low) & (value < high), spread, 0.0)
        at_low = self.below(law.law, frame)(low.astype(np.float64))
        at_high = self._above(law.law, frame, high.astype(np.float64))
        ends = np.where(value == low, at_low, np.where(value == high, at_high, inside))
        drawn = scalar_functions.clamp(point, low, high)
        return np.where(is_point | ~(low < high), np.where(value == drawn, 1.0, 0.0), ends)

    def _point(self, law: ir.Continuous, frame: Frame) -> tuple[Array, Array]:
        """Return where a law has no width, and the value that it draws there."""
        match law:
            case ir.Normal():
                return ~(np.abs(self.value(law.deviation, frame)) > 0.0), self.value(law.mean, frame)
            case ir.UniformFloat():
                low, high = self.value(law.low, frame), self.value(law.high, frame)
                return ~(high > low), high
            case ir.Exponential():
                return ~(self._mean(law, frame) > 0.0), np.asarray(0.0, dtype=np.float32)
            case ir.Truncated():
                low, high = self.value(law.low, frame), self.value(law.high, frame)
                inner, point = self._point(law.law, frame)
                has_total = self._total(law, frame) > 0.0
                drawn = np.where(has_total, point, np.where(point < low, low, high))
                return ~has_total | inner, drawn
        raise TypeError(f"no density of {type(law).__name__}")

    def _spread_of(self, law: ir.Continuous, frame: Frame, x: Array) -> Array:
        """Return the density of a double where the law has a width."""
        match law:
            case ir.Normal():
                mean, deviation = self._doubles(frame, law.mean, law.deviation)
                z = (x - mean) / np.abs(deviation)
                return np.asarray(_decay(z * z * -0.7213475204444817) * _PEAK / np.abs(deviation))
            case ir.UniformFloat():
                low, high = self._doubles(frame, law.low, law.high)
                return np.where((x >= low) & (x <= high), 1.0 / (high - low), 0.0)
            case ir.Exponential():
                mean = self._mean(law, frame).astype(np.float64)
                return np.where(x >= 0.0, _decay(x / mean * -1.4426950408889634) / mean, 0.0)
            case ir.Truncated():
                low, high = self._doubles(frame, law.low, law.high)
                inside = (x >= low) & (x <= high)
                return np.where(inside, self._spread_of(law.law, frame, x) / self._total(law, frame), 0.0)
        raise TypeError(f"no density of {type(law).__name__}")

    def _above(self, law: ir.Continuous, frame: Frame, x: Array) -> Array:
        """Return the probability above a double, of a normal or exponential law in the upper tail."""
        match law:
            case ir.Normal():
                mean, deviation = self._doubles(frame, law.mean, law.deviation)
                return normal_cdf(-((x - mean) / np.abs(deviation)))
            case ir.Exponential():
                return _survival(x, self._mean(law, frame).astype(np.float64))
        return 1.0 - self.below(law, frame)(x)

    # Bins --------------------------------------------------------------------------------------

    def sample_bin(self, dist: ir.Binned, frame: Frame, word: Word) -> Array:
        """Return the bin drawn in each lane: the first whose words are not passed, found by halving."""
        draw, up_to = word(), self._words_up_to(dist, frame)
        low, high = np.zeros(draw.shape, dtype=np.int64), np.asarray(size_of(dist.type) - 1)
        while np.any(low < high):
            middle = (low + high) // 2
            passed = draw >= up_to(middle)
            low, high = np.where(passed, np.minimum(middle + 1, high), low), np.where(passed, high, middle)
        return as_type(low + low_of(dist.type), dist.type)

    def density_of_bin(self, dist: ir.Binned, frame: Frame, value: Array) -> Array:
        """Return the probability of the bin ``value`` in each lane."""
        up_to, position = self._words_up_to(dist, frame), value.astype(np.int64) - low_of(dist.type)
        before = np.where(position > 0, up_to(position - 1), np.uint64(0))
        after = up_to(position)
        return share(np.where((position >= 0) & (after > before), after - before, np.uint64(0)))

    def _words_up_to(self, dist: ir.Binned, frame: Frame) -> Below:
        """Return the function that gives how many words lie in a bin or before it."""
        count = size_of(dist.type)
        low, high = self._doubles(frame, dist.low, dist.high)
        width = np.where(high > low, high - low, 0.0)
        below = self.below(dist.law, frame)

        def up_to(bin_: Array) -> Array:
            edge = low + width * ((bin_ + 1).astype(np.float64) / count)
            return np.where(bin_ >= count - 1, np.uint64(2**32), words_of(below(edge)))

        return up_to


def _decay(power: Array) -> Array:
    """Return 2^power; 0 where that is below the range of ``exp2_inside``, or no number."""
    inside = power >= -1000.0
    return np.where(inside, exp2_inside(np.where(inside, power, 0.0)), 0.0)


def _below_uniform(low: Array, high: Array, x: Array) -> Array:
    inside = (x - low) / (high - low)
    inside = np.where(inside < 0.0, 0.0, np.where(inside > 1.0, 1.0, inside))
    return np.where(high > low, inside, np.where(x > high, 1.0, 0.0))


def _between_normal(mean: Array, deviation: Array, low: Array, x: Array) -> Array:
    """Return the probability from ``low`` to ``x``, computed in the smaller tail."""
    a, b = (low - mean) / deviation, (x - mean) / deviation
    upper = a > 0.0
    return normal_cdf(np.where(upper, -a, b)) - normal_cdf(np.where(upper, -b, a))


def _between_exponential(mean: Array, low: Array, x: Array) -> Array:
    return _survival(low, mean) - _survival(x, mean)


def _survival(x: Array, mean: Array) -> Array:
    """Return the probability that an exponential number of this mean is not below ``x``."""
    power = (x / mean) * -1.4426950408889634
    power = np.where(power > -1000.0, power, -1000.0)
    inside = x > 0.0
    beyond = np.where(mean > 0.0, exp2_inside(np.where(inside, power, 0.0)), 0.0)
    return np.where(inside, beyond, 1.0)
