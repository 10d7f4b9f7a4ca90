# SPDX-License-Identifier: Apache-2.0
"""Intervals and comparisons of episodes that several settings have played in the same worlds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

RESAMPLES = 9999
_SEED = 20261130  # of the resamples: the same data give the same table


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % interval; nan where there are too few values."""

    mean: float
    low: float
    high: float
    count: int

    def __str__(self) -> str:
        if math.isnan(self.mean):
            return ""
        if math.isnan(self.low):
            return f"{self.mean:.3f}"
        return f"{self.mean:.3f} ({self.low:.3f} .. {self.high:.3f})"


@dataclass(frozen=True)
class Difference:
    """The mean of paired differences. ``p`` is adjusted for the table's other comparisons."""

    interval: Interval
    p: float

    @property
    def is_shown(self) -> bool:
        """Whether the difference is more than chance makes it, with 5 % for all comparisons of the table."""
        has_zero = self.interval.low <= 0.0 <= self.interval.high
        return self.p <= 0.05 and not math.isnan(self.interval.low) and not has_zero

    def __str__(self) -> str:
        text = str(self.interval)
        return f"{text}{'' if self.is_shown else ', not shown'}" if text else ""


def mean_of(values: Iterable[float]) -> Interval:
    """Return the mean with its interval by the bootstrap (bias-corrected and accelerated, Efron 1987)."""
    sample = np.array(list(values), dtype=float)
    if len(sample) == 0:
        return Interval(math.nan, math.nan, math.nan, 0)
    mean = float(sample.mean())
    if len(sample) < 3:
        return Interval(mean, math.nan, math.nan, len(sample))
    if (
        np.ptp(sample) <= 1e-12 * np.abs(sample).max()
    ):  # equal but for rounding: the bootstrap gives no interval
        return Interval(mean, mean, mean, len(sample))
    found = stats.bootstrap(
        (sample,), np.mean, n_resamples=RESAMPLES, rng=np.random.default_rng(_SEED), method="BCa"
    ).confidence_interval
    return Interval(mean, float(found.low), float(found.high), len(sample))


def compare(
    pairs: Sequence[tuple[Mapping[int, float], Mapping[int, float]]],
) -> list[Difference]:
    """Return ours minus theirs of each pair, over the episodes that both have played.

    A p-value is that of random signs of the differences, two-sided. Holm's method (1979) adjusts them for
    each other.
    """
    samples = [_differences(ours, theirs) for ours, theirs in pairs]
    return [
        Difference(mean_of(sample), p)
        for sample, p in zip(samples, holm([_sign_test(sample) for sample in samples]), strict=True)
    ]


def holm(ps: Sequence[float]) -> list[float]:
    """Return p-values adjusted by Holm's method; nan stays nan and does not count."""
    known = sorted((p, i) for i, p in enumerate(ps) if not math.isnan(p))
    adjusted, largest = [math.nan] * len(ps), 0.0
    for rank, (p, i) in enumerate(known):
        largest = max(largest, min(1.0, p * (len(known) - rank)))
        adjusted[i] = largest
    return adjusted


def _differences(ours: Mapping[int, float], theirs: Mapping[int, float]) -> list[float]:
    return [ours[episode] - theirs[episode] for episode in sorted(ours.keys() & theirs.keys())]


def _sign_test(sample: Sequence[float]) -> float:
    """Return how probable so large a mean is where each difference is as likely to have the other sign."""
    values = np.array(sample, dtype=float)
    if len(values) < 3:
        return math.nan
    if not values.any():
        return 1.0
    signs = np.random.default_rng(_SEED).choice((-1.0, 1.0), size=(RESAMPLES, len(values)))
    means = np.abs(signs @ values)
    return float((1 + np.count_nonzero(means >= abs(values.sum()) * (1 - 1e-12))) / (RESAMPLES + 1))
