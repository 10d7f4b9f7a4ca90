# SPDX-License-Identifier: Apache-2.0
"""Trigonometric functions: ``math/trigonometry.hpp`` in numpy, operation by operation.

An angle is reduced modulo pi/2 with a rest that is right to about 2^-52 of itself below 2^20 and to 2^-70
above, where the least rest of a float32 is about 2^-30. The series of the rest err by less than 2^-58.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hypgen.dsl.interpret.floats.bits import Array, double, quiet, single

_PI, _HALF_PI = 3.141592653589793, 1.5707963267948966
# 32 zero bits, then those of 2/pi.
_TWO_OVER_PI = np.array(
    [0, 0xA2F9836E, 0x4E441529, 0xFC2757D1, 0xF534DDC0, 0xDB629599, 0x3C439041, 0xFE5163AB], dtype=np.uint64
)
_LOW = np.uint64(0xFFFFFFFF)
_32, _62 = np.uint64(32), np.uint64(62)
_EIGHTHS = np.array(
    [
        *(0.0, 0.12435499454676144, 0.24497866312686414, 0.35877067027057225, 0.4636476090008061),
        *(0.5585993153435624, 0.6435011087932844, 0.7188299996216245, 0.7853981633974483),
    ]
)
# The signs alternate, as in the series.
_SINE = (-1307674368000, 6227020800, -39916800, 362880, -5040, 120, -6)
_COSINE = (-87178291200, 479001600, -3628800, 40320, -720, 24, -2)
_ARC = (13, -11, 9, -7, 5, -3)


def _reduce_small(x: Array) -> tuple[Array, Array]:
    """Return rest and quadrant of 0 <= x <= 2^20."""
    n = np.floor(x * 0.6366197723675814 + 0.5)
    rest = ((x - n * 1.5707963267341256) - n * 6.077100506303966e-11) - n * 2.0222662487959506e-21
    return rest, n.astype(np.int64) & 3


def _reduce_large(x: Array) -> tuple[Array, Array]:
    """Return rest and quadrant of float32 values x >= 2^20, by integers (Payne and Hanek)."""
    bits = x.view(np.uint64)
    m = ((bits >> np.uint64(29)) & np.uint64(0x7FFFFF)) | np.uint64(0x800000)
    start = (bits >> np.uint64(52)).astype(np.int64) - 1046 + 30
    word = start >> 5
    shift = (32 - (start & 31)).astype(np.uint64)
    part = []
    for i in range(3):
        pair = (_TWO_OVER_PI[word + i] << _32) | _TWO_OVER_PI[word + i + 1]
        part.append(m * ((pair >> shift) & _LOW))
    part[1] = part[1] + (part[2] >> _32)
    part[0] = part[0] + (part[1] >> _32)
    top = (part[0] << _32) | (part[1] & _LOW)
    quadrant = (top + (np.uint64(1) << np.uint64(61))) >> _62
    high = (top - (quadrant << _62)).astype(np.int64)
    fraction = high.astype(np.float64) * 2.0**-62 + (part[2] & _LOW).astype(np.float64) * 2.0**-94
    return fraction * _HALF_PI, quadrant.astype(np.int64)


def _reduce(x: Array) -> tuple[Array, Array]:
    """Return rest and quadrant of x >= 0; of 0 where x is not finite."""
    finite = np.where(x < np.inf, x, 0.0)
    small = finite <= 1048576.0
    near = _reduce_small(np.where(small, finite, 0.0))
    far = _reduce_large(np.where(small, 1048576.0, finite))
    return np.where(small, near[0], far[0]), np.where(small, near[1], far[1])


def _series(s: Array, first: float, divisors: tuple[int, ...]) -> Array:
    total: Array = np.full_like(s, 1.0 / first)
    for divisor in divisors:
        total = total * s + 1.0 / divisor
    return total


def _sin_near(r: Array) -> Array:
    s = r * r
    result: Array = r + r * (_series(s, 355687428096000.0, _SINE) * s)
    return result


def _cos_near(r: Array) -> Array:
    s = r * r
    result: Array = _series(s, 20922789888000.0, _COSINE) * s + 1.0
    return result


def sin(x: npt.ArrayLike) -> Array:
    """Return the sine."""
    with quiet():
        y = double(x)
        rest, quadrant = _reduce(np.abs(y))
        value = np.where(quadrant & 1 != 0, _cos_near(rest), _sin_near(rest))
        negative = (quadrant & 2 != 0) != np.signbit(y)
        return single(np.where(np.isfinite(y), np.where(negative, -value, value), np.nan))


def cos(x: npt.ArrayLike) -> Array:
    """Return the cosine."""
    with quiet():
        y = double(x)
        rest, quadrant = _reduce(np.abs(y))
        value = np.where(quadrant & 1 != 0, _sin_near(rest), _cos_near(rest))
        negative = (quadrant + 1) & 2 != 0
        return single(np.where(np.isfinite(y), np.where(negative, -value, value), np.nan))


def tan(x: npt.ArrayLike) -> Array:
    """Return the tangent."""
    with quiet():
        y = double(x)
        rest, quadrant = _reduce(np.abs(y))
        sine, cosine = _sin_near(rest), _cos_near(rest)
        odd = quadrant & 1 != 0
        value = np.where(odd, cosine / sine, sine / cosine)
        return single(np.where(np.isfinite(y), np.where(odd != np.signbit(y), -value, value), np.nan))


def _atan_below_one(a: Array, b: Array) -> Array:
    k = np.floor(a / b * 8.0 + 0.5)
    c = k * 0.125
    u = (a - c * b) / (b + c * a)
    s = u * u
    return _EIGHTHS[k.astype(np.int64)] + (u + u * (_series(s, -15.0, _ARC) * s))


def _atan2(y: Array, x: Array) -> Array:
    bad = np.isnan(x) | np.isnan(y)
    y_size, x_size = np.where(bad, 1.0, np.abs(y)), np.where(bad, 1.0, np.abs(x))
    steep = y_size > x_size
    a, b = np.where(steep, x_size, y_size), np.where(steep, y_size, x_size)
    b = np.where(b == 0.0, 1.0, b)
    a = np.where(b == np.inf, np.where(a == np.inf, 1.0, 0.0), a)
    b = np.where(b == np.inf, 1.0, b)
    angle = _atan_below_one(a, b)
    angle = np.where(steep, _HALF_PI - angle, angle)
    angle = np.where(np.signbit(x), _PI - angle, angle)
    return np.where(bad, np.nan, np.where(np.signbit(y), -angle, angle))


def asin(x: npt.ArrayLike) -> Array:
    """Return the angle in [-pi/2, pi/2] whose sine is x; NaN beyond +-1."""
    with quiet():
        y = double(x)
        return single(_atan2(y, np.sqrt((1.0 - y) * (1.0 + y))))


def acos(x: npt.ArrayLike) -> Array:
    """Return the angle in [0, pi] whose cosine is x; NaN beyond +-1."""
    with quiet():
        y = double(x)
        return single(_atan2(np.sqrt((1.0 - y) * (1.0 + y)), y))


def atan2(y: npt.ArrayLike, x: npt.ArrayLike) -> Array:
    """Return the angle of the point (x, y) from the x axis, with C's rules for zeros, infinities and NaN."""
    with quiet():
        return single(_atan2(*np.broadcast_arrays(double(y), double(x))))
