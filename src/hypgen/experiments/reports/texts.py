# SPDX-License-Identifier: Apache-2.0
"""Numbers as a page shows them."""

from __future__ import annotations

import math

from hypgen.experiments.statistics import Interval

_MOST_DECIMALS = 4


def mean_text(value: Interval) -> str:
    """Return a mean with as many decimals as its interval lets one believe, and one more."""
    return number(value.mean, _decimals(value))


def interval_text(value: Interval) -> str:
    """Return the two ends of an interval; empty where they are not known."""
    if not value.is_known:
        return ""
    decimals = _decimals(value)
    return f"{number(value.low, decimals)} to {number(value.high, decimals)}"


def _decimals(value: Interval) -> int:
    width = value.high - value.low if value.is_known else 0.0
    if not width > 1e-9 * abs(value.mean):
        return 2
    return min(max(1 - math.floor(math.log10(width / 2)), 0), _MOST_DECIMALS)


def number(value: float, decimals: int) -> str:
    """Return a number with a true minus and commas; empty where it is not known."""
    if not math.isfinite(value):
        return ""
    text = f"{value:,.{decimals}f}"
    return (text.removeprefix("-") if float(text.replace(",", "")) == 0.0 else text).replace("-", "\u2212")


def signed(value: Interval) -> str:
    """Return a difference, with its sign."""
    text = mean_text(value)
    return f"+{text}" if value.mean > 0.0 and text.strip("0.,") else text


def count_text(value: float) -> str:
    """Return a count with three digits, or all of a larger one."""
    if not math.isfinite(value):
        return ""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def percent(value: float) -> str:
    """Return a share as per cent, with a decimal unless it is 0 or 1."""
    return f"{100 * value:.{0 if value in (0.0, 1.0) else 1}f} %" if math.isfinite(value) else ""


def seconds_text(value: float) -> str:
    """Return a time in seconds, milliseconds or microseconds."""
    if not math.isfinite(value):
        return ""
    for unit, scale in (("s", 1.0), ("ms", 1e3), ("\u00b5s", 1e6)):
        if value * scale >= 0.9995 or unit == "\u00b5s":
            return f"{value * scale:.3g} {unit}"
    raise AssertionError("the last unit takes what is left")
