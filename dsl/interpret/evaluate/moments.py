# SPDX-License-Identifier: Apache-2.0
"""The arithmetic of beliefs that a policy keeps as the mean and the deviation of a float.

Each class is that of ``belief/moments.hpp`` of the same name, operation by operation, for many lanes at once.
Numbers are float64; what is kept is float32.
"""

from __future__ import annotations

import numpy as np

from hypgen.dsl.interpret.evaluate.values import Array
from hypgen.dsl.interpret.floats.exponentials import exp2_inside, log_double
from hypgen.dsl.interpret.floats.scalar_functions import WHOLE, after, share_of

POINTS = 32
_MOST_SWEEPS = 4


class Sums:
    """Weighted numbers, relative to the first of them so that little cancels."""

    def __init__(self, lanes: int) -> None:
        self.shift, self.total, self.first, self.second = (np.zeros(lanes) for _ in range(4))

    def add(self, weight: Array, mean: Array, variance: Array | float = 0.0) -> None:
        """Add a number, or a law of this mean and variance, where the weight is above 0."""
        counts = weight > 0.0
        self.shift = np.where(counts & ~(self.total > 0.0), mean, self.shift)
        distance = mean - self.shift
        self.total = np.where(counts, self.total + weight, self.total)
        self.first = np.where(counts, self.first + weight * distance, self.first)
        self.second = np.where(counts, self.second + weight * (distance * distance + variance), self.second)

    def mean(self) -> Array:
        """Return the mean, 0 of nothing."""
        some = self.total > 0.0
        return np.where(some, self.shift + self.first / np.where(some, self.total, 1.0), 0.0)

    def deviation(self) -> Array:
        """Return the deviation, 0 of nothing."""
        some = self.total > 0.0
        total = np.where(some, self.total, 1.0)
        middle = self.first / total
        variance = self.second / total - middle * middle
        return np.where(some & (variance > 0.0), np.sqrt(np.where(variance > 0.0, variance, 0.0)), 0.0)

    def kept(self) -> Array:
        """Return mean and deviation as they are kept: lanes by two."""
        return kept(self.mean(), self.deviation())


def kept(mean: Array, deviation: Array) -> Array:
    """Return mean and deviation as they are kept: lanes by two."""
    return np.stack([mean, deviation], axis=-1).astype(np.float32)


class Law:
    """The law of a float that is known by mean and deviation: normal, or the beta law of a range."""

    def __init__(self, known: Array, ends: tuple[Array, Array] | None) -> None:
        self.mean, self.deviation = known[..., 0].astype(np.float64), known[..., 1].astype(np.float64)
        self.ends = None
        if ends is None:
            return
        low, high = (np.asarray(e).astype(np.float64) for e in ends)
        self.ends = low, high
        place = (self.mean - low) / (high - low)
        fine = (high > low) & (self.deviation > 0.0) & (place > 0.0) & (place < 1.0)
        self.deviation = np.where(fine, self.deviation, 0.0)
        place = np.where(fine, place, 0.5)
        width = np.where(fine, self.deviation / (high - low), 0.25)
        size = place * (1.0 - place) / (width * width) - 1.0
        bounded = np.where(size > 0.001, size, 0.001)
        self._below, self._above = place * bounded - 1.0, (1.0 - place) * bounded - 1.0
        self._log_below, self._log_above = log_double(place), log_double(1.0 - place)

    def density(self, x: Array) -> Array:
        """Return the density at x over that at the mean; 0 at the ends of a range and beyond."""
        spread = self.deviation > 0.0
        if self.ends is None:
            z = (x.astype(np.float64) - self.mean) / self.deviation
            return np.where(spread, _power_of_two(z * z * -0.7213475204444817), 1.0)
        low, high = self.ends
        place = (x.astype(np.float64) - low) / (high - low)
        rest = 1.0 - place
        inside = (place > 0.0) & (rest > 0.0)
        lower = self._below * (log_double(np.where(inside, place, 0.5)) - self._log_below)
        upper = self._above * (log_double(np.where(inside, rest, 0.5)) - self._log_above)
        found = np.where(inside, _power_of_two((lower + upper) * 1.4426950408889634), 0.0)
        return np.where(spread, found, 1.0)


def _power_of_two(y: Array) -> Array:
    counts = y >= -1000.0
    power = np.where(counts, np.where(y < 1000.0, y, 1000.0), 0.0)
    return np.where(counts, exp2_inside(power), 0.0)


class Points:
    """The middles of equal parts of an interval, within the law's range."""

    def __init__(self, law: Law, center: Array, radius: Array) -> None:
        self.left, right = center - 6.0 * radius, center + 6.0 * radius
        if law.ends is not None:
            low, high = law.ends
            self.left = np.where(self.left < low, low, self.left)
            right = np.where(right > high, high, right)
        self.step = (right - self.left) * (1.0 / POINTS)

    def at(self, k: int) -> Array:
        """Return a point of each lane, float32."""
        point: Array = (self.left + self.step * (k + 0.5)).astype(np.float32)
        return point


class Mixture:
    """What a law, or a law for each point, comes to: its parts are added one by one."""

    def __init__(self, lanes: int) -> None:
        self._sums = Sums(lanes)
        self._x, self._weight = np.zeros(lanes), np.ones(lanes)
        self._still = np.ones(lanes, dtype=np.bool_)

    def at(self, x: Array, weight: Array) -> None:
        """Parts that follow belong to the point x."""
        self._x, self._weight = x.astype(np.float64), weight

    def certain(self, share: Array, value: Array) -> None:
        """Add a value."""
        self._add(share, value.astype(np.float64), np.asarray(0.0))

    def normal(self, share: Array, mean: Array, deviation: Array) -> None:
        """Add a normal law."""
        size = deviation.astype(np.float64)
        self._add(share, mean.astype(np.float64), size * size)

    def uniform(self, share: Array, low: Array, high: Array) -> None:
        """Add a uniform law."""
        end = high.astype(np.float64)
        width = np.where(high > low, end - low.astype(np.float64), 0.0)
        self._add(share, end - width * 0.5, width * width / 12.0)

    def exponential(self, share: Array, mean: Array) -> None:
        """Add an exponential law."""
        size = np.where(mean > 0.0, mean.astype(np.float64), 0.0)
        self._add(share, size, size * size)

    def _add(self, share: Array, mean: Array, variance: Array) -> None:
        weight = self._weight * share
        self._still &= ~(weight > 0.0) | ((mean == self._x) & (variance == 0.0))
        self._sums.add(weight, mean, variance)

    def kept(self) -> Array:
        """Return mean and deviation: lanes by two."""
        return self._sums.kept()

    def moved(self, now: Array) -> Array:
        """Return the same, or ``now`` where every point stays where it is."""
        return np.where(self._still[:, np.newaxis], now, self.kept())


class Shares:
    """The shares of a table's entries, which are shares of their masses."""

    def __init__(self) -> None:
        self._until: Array = np.zeros((), dtype=np.uint64)

    def take(self, mass: Array) -> Array:
        """Return the share of the next entry."""
        before = self._until
        self._until = after(before, mass)
        return share_of(self._until - before)

    def rest(self) -> Array:
        """Return what is left."""
        return share_of(WHOLE - self._until)


class Update:
    """Bayes' rule by adaptive quadrature; lanes that are done keep what they have."""

    def __init__(self, law: Law) -> None:
        self._law = law
        self._points = Points(law, law.mean, law.deviation)
        self._sums = Sums(len(law.mean))
        self._mean, self._deviation = law.mean, law.deviation
        self._due = law.deviation > 0.0
        self._sweeps = 0

    def due(self) -> bool:
        """Return whether a lane needs another sweep."""
        return bool(self._due.any())

    def points(self) -> Array:
        """Return the points of all lanes: lanes by points."""
        return np.stack([self._points.at(k) for k in range(POINTS)], axis=1)

    def sweep(self, x: Array, likelihood: Array) -> None:
        """Take how likely each point makes what was seen: both lanes by points."""
        for k in range(POINTS):
            self._sums.add(self._law.density(x[:, k]) * likelihood[:, k], x[:, k].astype(np.float64))
        self._sweeps += 1
        alike = (likelihood == likelihood[:, :1]).all(axis=1) & (self._sweeps == 1)
        fine = self._due & ~alike & (self._sums.total > 0.0)
        mean, found, step = self._sums.mean(), self._sums.deviation(), self._points.step
        least = step * 0.2886751345948129
        self._mean = np.where(fine, mean, self._mean)
        self._deviation = np.where(fine, np.where(found > least, found, least), self._deviation)
        self._due = fine & (found < step) & (self._sweeps < _MOST_SWEEPS)
        self._points = Points(self._law, self._mean, np.where(found > step * 0.5, found, step * 0.5))
        self._sums = Sums(len(self._mean))

    def kept(self) -> Array:
        """Return mean and deviation: lanes by two."""
        return kept(self._mean, self._deviation)
