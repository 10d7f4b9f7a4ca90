# SPDX-License-Identifier: Apache-2.0
"""Square roots, exponentials, logarithms and powers: ``math/exponentials.hpp`` in numpy.

The polynomials are plain series. The logarithm of the mantissa m in (sqrt(1/2), sqrt(2)] is 2 atanh(z) with
z = (m - 1) / (m + 1), so |z| < 0.1716 and stopping after z^21 errs by less than 2^-57 of the result. 2^f for
|f| <= 1/2 is the Taylor series of e^(f ln 2); stopping after the 13th power errs by less than 2^-57. Rounding
errors are larger than both: about 2^-51 in a logarithm and 2^-44 in a power, where float32 needs 2^-24.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hypgen.dsl.interpret.floats.bits import Array, double, quiet, single


def _split(x: Array) -> tuple[Array, Array]:
    """Take positive finite doubles apart: mantissa in (sqrt(1/2), sqrt(2)] and exponent."""
    bits = np.asarray(x).view(np.int64)
    exponent = ((bits >> 52) - 1023).astype(np.float64)
    mantissa = np.asarray((bits & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64)
    large = mantissa > 1.4142135623730951
    return np.where(large, mantissa * 0.5, mantissa), np.where(large, exponent + 1.0, exponent)


def _atanh_over(z: Array) -> Array:
    s = z * z
    total: Array = np.full_like(s, 1.0 / 21.0)
    for odd in range(19, 0, -2):
        total = total * s + 1.0 / odd
    return total


def _scaled_log(x: Array, per_octave: float, scale: float) -> Array:
    mantissa, exponent = _split(x)
    z = (mantissa - 1.0) / (mantissa + 1.0)
    result = exponent * per_octave + (z * _atanh_over(z)) * scale
    special = [np.isnan(x) | (x < 0.0), x == 0.0, x == np.inf]
    return np.select(special, [np.nan, -np.inf, np.inf], result)


def log_double(x: Array) -> Array:
    """Return the natural logarithm of doubles that are not subnormal."""
    return _scaled_log(x, 0.6931471805599453, 2.0)


def _log2(x: Array) -> Array:
    return _scaled_log(x, 1.0, 2.8853900817779268)


_FACTORIALS = (479001600, 39916800, 3628800, 362880, 40320, 5040, 720, 120, 24, 6, 2, 1, 1)


def exp2_inside(y: Array) -> Array:
    """Return 2^y of doubles, |y| <= 1000."""
    n = np.floor(y + 0.5)
    t = (y - n) * 0.6931471805599453
    total: Array = np.full_like(t, 1.0 / 6227020800.0)
    for factorial in _FACTORIALS:
        total = total * t + 1.0 / factorial
    result: Array = total * np.asarray((n.astype(np.int64) + 1023) << 52).view(np.float64)
    return result


def _exp2(y: Array) -> Array:
    result = exp2_inside(np.where((y >= -200.0) & (y <= 200.0), y, 0.0))
    return np.select([np.isnan(y), y > 200.0, y < -200.0], [np.nan, np.inf, 0.0], result)


def sqrt(x: npt.ArrayLike) -> Array:
    """Return the IEEE square root."""
    with quiet():
        return single(np.sqrt(np.asarray(x, dtype=np.float32)))


def log2(x: npt.ArrayLike) -> Array:
    """Return the logarithm to base 2."""
    with quiet():
        return single(_log2(double(x)))


def log(x: npt.ArrayLike) -> Array:
    """Return the natural logarithm."""
    with quiet():
        return single(log_double(double(x)))


def exp2(x: npt.ArrayLike) -> Array:
    """Return 2^x."""
    with quiet():
        return single(_exp2(double(x)))


def exp(x: npt.ArrayLike) -> Array:
    """Return e^x."""
    with quiet():
        return single(_exp2(double(x) * 1.4426950408889634))


def hypot(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return sqrt(a^2 + b^2)."""
    with quiet():
        x, y = double(a), double(b)
        return single(np.sqrt(x * x + y * y))


def pow(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return a^b with C's rules for zeros, infinities and negative bases."""
    with quiet():
        x, y = np.broadcast_arrays(double(a), double(b))
        size = np.where(x < 0.0, -x, x)
        whole = np.floor(y) == y
        odd = whole & (np.floor(y * 0.5) != y * 0.5)
        power = np.where(size == 1.0, 1.0, _exp2(y * _log2(size)))
        result = np.where(odd & np.signbit(x), -power, power)
        undefined = np.isnan(y) | ((x < 0.0) & (size < np.inf) & ~whole)
        return single(np.select([(y == 0.0) | (x == 1.0), undefined], [1.0, np.nan], result))
