# SPDX-License-Identifier: Apache-2.0
"""Axes of figures: from values to places, with round numbers at their ticks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)  # between ticks, times a power of ten
_ROOM = 0.06  # beside the outermost values, as a share of the axis


@dataclass(frozen=True)
class Scale:
    """Values from ``low`` to ``high`` along pixels from ``start`` to ``end``."""

    low: float
    high: float
    start: float
    end: float
    is_log: bool

    def __call__(self, value: float) -> float:
        """Return the place of a value; one beyond the axis is at its end."""
        low, high, at = (
            math.log10(v) if self.is_log else v for v in (self.low, self.high, self._within(value))
        )
        return self.start + (at - low) / (high - low) * (self.end - self.start)

    def _within(self, value: float) -> float:
        return min(max(value, self.low), self.high)

    def ticks(self, most: int = 6) -> list[float]:
        """Return round numbers within the axis, about ``most``."""
        return _log_ticks(self.low, self.high, most) if self.is_log else _ticks(self.low, self.high, most)


def scale_of(values: Iterable[float], start: float, end: float, is_log: bool = False) -> Scale:
    """Return a scale that shows all values, with some room beside them."""
    found = [value for value in values if math.isfinite(value) and (value > 0.0 or not is_log)]
    low, high = (min(found), max(found)) if found else (0.0, 1.0)
    if is_log:
        room = max(_ROOM * math.log10(high / low), 0.05)
        return Scale(low / 10**room, high * 10**room, start, end, True)
    room = _ROOM * (high - low) or 0.1 * abs(high) or 1.0
    return Scale(low - room, high + room, start, end, False)


def _ticks(low: float, high: float, most: int) -> list[float]:
    power = 10.0 ** math.floor(math.log10((high - low) / most))
    step = next(one * power for one in _STEPS if (high - low) / (one * power) <= most)
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 12) + 0.0 for i in range(first, math.floor(high / step + 1e-9) + 1)]


def _log_ticks(low: float, high: float, most: int) -> list[float]:
    """Return powers of ten, thinned where there are many and with 2 and 5 between where there are few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for digits in ((1, 2, 5), (1, 3), (1,)):
        found = [digit * 10.0**power for power in powers for digit in digits]
        found = [value for value in found if low <= value <= high]
        if len(found) <= most:
            return found
    return found[:: math.ceil(len(found) / most)]


def tick_label(value: float) -> str:
    """Return a number as an axis shows it."""
    if value == 0.0:
        return "0"
    if abs(value) >= 1e6 or abs(value) < 1e-3:
        power = math.floor(math.log10(abs(value)) + 1e-9)
        digits = value / 10.0**power
        times = "" if abs(digits - 1.0) < 1e-9 else f"{digits:g}\u00d7"
        return f"{times}10{str(power).translate(_RAISED)}"
    text = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:g}"
    return text.replace("-", "\u2212")


_RAISED = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")
