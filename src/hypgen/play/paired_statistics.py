# SPDX-License-Identifier: Apache-2.0
"""Statistics of episodes that several settings play in the same worlds."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping


def interval(values: Iterable[float]) -> tuple[float, float]:
    """Return the mean and the half-width of its 95 % interval, 1.96 standard errors; nan where too few."""
    numbers = list(values)
    if not numbers:
        return math.nan, math.nan
    half = 1.96 * statistics.stdev(numbers) / math.sqrt(len(numbers)) if len(numbers) > 1 else math.nan
    return statistics.fmean(numbers), half


def differences(ours: Mapping[int, float], theirs: Mapping[int, float]) -> list[float]:
    """Return ours minus theirs in each episode that both have played, in the order of the episodes."""
    return [ours[episode] - theirs[episode] for episode in sorted(ours.keys() & theirs.keys())]


def with_interval(values: Iterable[float], sign: str = "") -> str:
    """Return "mean +- half" of some values for a table, as far as known; ``sign`` "+" shows the mean's."""
    mean, half = interval(values)
    if math.isnan(mean):
        return ""
    return f"{mean:{sign}.3f}" if math.isnan(half) else f"{mean:{sign}.3f} +- {half:.3f}"
