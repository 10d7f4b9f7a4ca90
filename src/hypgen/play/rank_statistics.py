# SPDX-License-Identifier: Apache-2.0
"""Statistics of ranks: are they uniform on 0 .. 1, and if not, how do they lie?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

_MOST_BINS, _LEAST_EXPECTED = 20, 5
_BLOCKS = "▁▂▃▄▅▆▇█"
_TELLING = 3.0  # standard errors from which on a shape has a name


@dataclass(frozen=True)
class Ranks:
    """The ranks of a variable's true values in the belief, one an episode."""

    values: Sequence[float]

    def histogram(self) -> list[int]:
        """Return how many ranks each of up to 20 equal bins holds; in the mean a bin has at least 5."""
        bins = max(1, min(_MOST_BINS, len(self.values) // _LEAST_EXPECTED))
        counts = [0] * bins
        for value in self.values:
            counts[min(int(value * bins), bins - 1)] += 1
        return counts

    def blocks(self) -> str:
        """Return the histogram as a line of blocks; half of a block's height is the mean."""
        counts = self.histogram()
        mean = max(1, len(self.values)) / len(counts)
        tops = (min(len(_BLOCKS) - 1, round(count / mean * len(_BLOCKS) / 2 - 0.5)) for count in counts)
        return "".join(_BLOCKS[max(0, top)] for top in tops)

    def p(self) -> float:
        """Return how often a histogram of uniform ranks is as far from level, by a chi-square test."""
        counts = self.histogram()
        if len(counts) < 2:
            return 1.0
        mean = len(self.values) / len(counts)
        return chi_square_tail(sum((count - mean) ** 2 for count in counts) / mean, len(counts) - 1)

    def coverage(self, share: float) -> tuple[float, float, float]:
        """Return how often the central interval of ``share`` of the belief holds the true value.

        Wilson's 95 % interval of that follows.
        """
        n = len(self.values)
        if n == 0:
            return math.nan, math.nan, math.nan
        held = sum(abs(value - 0.5) <= share / 2 for value in self.values) / n
        z = 1.96
        middle, half = held + z * z / (2 * n), z * math.sqrt(held * (1 - held) / n + (z / (2 * n)) ** 2)
        return held, (middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)

    def shape(self) -> str:
        """Return how the belief errs: ``low`` or ``high``, ``sure`` (too much so), ``wide`` or ``uneven``."""
        n = max(1, len(self.values))
        lean = (sum(self.values) / n - 0.5) * math.sqrt(12 * n)
        spread = (sum((value - 0.5) ** 2 for value in self.values) / n - 1 / 12) * math.sqrt(180 * n)
        if max(abs(lean), abs(spread)) < _TELLING:
            return "uneven"
        if abs(lean) > abs(spread):
            return "low" if lean > 0 else "high"
        return "sure" if spread > 0 else "wide"


def chi_square_tail(x: float, degrees: int) -> float:
    """Return the probability that chi-square of so many degrees of freedom is above ``x``.

    The regularised gamma function Q(a, h) by Q(1/2, h) = erfc(sqrt(h)), Q(1, h) = exp(-h) and
    Q(a + 1, h) = Q(a, h) + h^a exp(-h) / gamma(a + 1). All terms are positive.
    """
    half = x / 2
    if half <= 0:
        return 1.0
    a, tail = (0.5, math.erfc(math.sqrt(half))) if degrees % 2 else (1.0, math.exp(-half))
    while a < degrees / 2:
        tail += math.exp(a * math.log(half) - half - math.lgamma(a + 1))
        a += 1
    return min(1.0, tail)


def corrected(values: Sequence[float]) -> list[float]:
    """Return p values corrected for their number, by Holm's method, in the same order."""
    result, largest = [0.0] * len(values), 0.0
    for done, i in enumerate(sorted(range(len(values)), key=values.__getitem__)):
        largest = max(largest, min(1.0, (len(values) - done) * values[i]))
        result[i] = largest
    return result
