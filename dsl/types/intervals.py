# SPDX-License-Identifier: Apache-2.0
"""Interval arithmetic: exact for ints, sound under float32 rounding for floats.

An interval is a pair (low, high). Float ends are rounded to float32 as the operation itself rounds; rounding
is monotone, so that rounded ends still enclose every rounded result.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable

Ends = tuple[float, float]
IntEnds = tuple[int, int]

# exp, log and pow round from a double that is itself not exact: one part in 2^22 covers it.
_SLACK = 2.0**-22
# What float32 arithmetic on constants is taken to lose, for each unit of the largest: an estimate.
ESTIMATE = 2.0**-20


def float32(value: float) -> float:
    """Return ``value`` rounded to the nearest float32."""
    if math.isnan(value) or math.isinf(value):
        return value
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def half_place(size: float) -> float:
    """Return half of the place of the last bit of a float32: no number of that size is rounded by more."""
    if not math.isfinite(size):
        return math.inf
    return math.ldexp(1.0, max(math.frexp(size)[1], -125) - 25) if size else 0.0


def rounded(ends: Ends) -> Ends:
    """Return float ends as float32; an end that is no number becomes infinite."""
    low, high = ends
    return (
        -math.inf if math.isnan(low) else float32(low),
        math.inf if math.isnan(high) else float32(high),
    )


def add(a: Ends, b: Ends) -> Ends:
    """Return the ends of a + b."""
    return a[0] + b[0], a[1] + b[1]


def sub(a: Ends, b: Ends) -> Ends:
    """Return the ends of a - b."""
    return a[0] - b[1], a[1] - b[0]


def _product(x: float, y: float) -> float:
    return 0 if x == 0 or y == 0 else x * y


def mul(a: Ends, b: Ends) -> Ends:
    """Return the ends of a * b."""
    return hull(_product(x, y) for x in a for y in b)


def div(a: Ends, b: Ends) -> Ends:
    """Return the ends of a / b of floats; everything if b may be 0."""
    if b[0] <= 0 <= b[1] or any(map(math.isinf, (*a, *b))):
        if a[0] >= 0 and b[0] >= 0:
            return 0.0, math.inf
        return -math.inf, math.inf
    return hull(x / y for x in a for y in b)


def floordiv(a: IntEnds, b: IntEnds) -> IntEnds:
    """Return the ends of a // b, which is 0 where b is 0."""
    divisors = {d for d in (b[0], b[1], -1, 1) if b[0] <= d <= b[1] and d != 0}
    quotients = [x // d for x in a for d in divisors]
    if b[0] <= 0 <= b[1]:
        quotients.append(0)
    return min(quotients), max(quotients)


def mod(a: IntEnds, b: IntEnds) -> IntEnds:
    """Return the ends of a % b, which has the sign of b and is 0 where b is 0."""
    if a[0] >= 0 and a[1] < b[0]:
        return a
    return min(0, b[0] + 1), max(0, b[1] - 1)


def int_power(a: IntEnds, exponent: int) -> IntEnds:
    """Return the ends of an int raised to a constant power."""
    ends = [a[0] ** exponent, a[1] ** exponent]
    if exponent % 2 == 0 and exponent > 0 and a[0] < 0 < a[1]:
        ends.append(0)
    return min(ends), max(ends)


def absolute(a: Ends) -> Ends:
    """Return the ends of |a|."""
    low = 0 if a[0] <= 0 <= a[1] else min(abs(a[0]), abs(a[1]))
    return low, max(abs(a[0]), abs(a[1]))


def power(a: Ends, b: Ends) -> Ends:
    """Return the ends of a ** b of floats, for bases that are not negative; everything otherwise."""
    if a[0] < 0:
        return -math.inf, math.inf
    if a[0] == 0 and b[0] < 0:
        return 0.0, math.inf
    return _widened(hull(_limit(_power, x, y) for x in (*a, *_inside(1.0, a)) for y in b))


def _power(x: float, y: float) -> float:
    return math.pow(x, y)


def _inside(value: float, a: Ends) -> tuple[float, ...]:
    return (value,) if a[0] < value < a[1] else ()


def hypotenuse(a: Ends, b: Ends) -> Ends:
    """Return the ends of hypot(a, b)."""
    x, y = absolute(a), absolute(b)
    return math.hypot(x[0], y[0]), math.hypot(x[1], y[1])


def monotone(function: Callable[[float], float], a: Ends) -> Ends:
    """Return the ends of a rising function, infinite where it is not defined."""
    low, high = (_limit(function, x) for x in a)
    return _widened((-math.inf if math.isnan(low) else low, math.inf if math.isnan(high) else high))


def _limit(function: Callable[..., float], *arguments: float) -> float:
    try:
        return function(*arguments)
    except OverflowError:
        return math.inf
    except ValueError:
        return math.nan


def _widened(ends: Ends) -> Ends:
    low, high = ends
    exact = (0.0, 1.0)
    return (
        low if low in exact else low - abs(low) * _SLACK,
        high if high in exact else high + abs(high) * _SLACK,
    )


def hull(values: Iterable[float]) -> Ends:
    """Return the least interval with all values; everything if one is no number."""
    found = list(values)
    if any(math.isnan(v) for v in found):
        return -math.inf, math.inf
    return min(found), max(found)


def repeated(a: Ends, count: int, always: bool) -> Ends:
    """Return the ends of a sum of ``count`` terms, each of which may be missing unless ``always``."""
    low, high = (a[0], a[1]) if always else (min(a[0], 0), max(a[1], 0))
    return _product(low, count), _product(high, count)
