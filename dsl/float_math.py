"""The scalar functions of models on arrays: what ``runtime/include/hypgen/math.hpp`` does, in numpy.

Float functions are computed in float64 by a fixed sequence of IEEE + - * /, sqrt and floor and rounded
once to float32. Each function here is the header's function of the same name, operation by operation;
change both or neither. Where C++ branches, all lanes compute every branch and the right one is chosen,
so floating-point warnings mean nothing here.

The polynomials are plain series. The logarithm of the mantissa m in (sqrt(1/2), sqrt(2)] is 2 atanh(z) with
z = (m - 1) / (m + 1), so |z| < 0.1716 and stopping after z^21 errs by less than 2^-57 of the result. 2^f for
|f| <= 1/2 is the Taylor series of e^(f ln 2); stopping after the 13th power errs by less than 2^-57. Rounding
errors are larger than both: about 2^-51 in a logarithm and 2^-44 in a power, where float32 needs 2^-24.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

FIXED_BITS = 24
_FIXED_LIMIT = 2**48
_INT32 = np.int32


def _quiet() -> np.errstate:
    return np.errstate(all="ignore")


def _double(x: npt.ArrayLike) -> Array:
    with _quiet():
        return np.asarray(x, dtype=np.float32).astype(np.float64)


def _single(x: Array) -> Array:
    with _quiet():
        return np.asarray(x).astype(np.float32)


# Floats ------------------------------------------------------------------------------------------


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


def _log2(x: Array) -> Array:
    return _scaled_log(x, 1.0, 2.8853900817779268)


_FACTORIALS = (479001600, 39916800, 3628800, 362880, 40320, 5040, 720, 120, 24, 6, 2, 1, 1)


def _exp2(y: Array) -> Array:
    inside = np.where((y >= -200.0) & (y <= 200.0), y, 0.0)
    n = np.floor(inside + 0.5)
    t = (inside - n) * 0.6931471805599453
    total: Array = np.full_like(t, 1.0 / 6227020800.0)
    for factorial in _FACTORIALS:
        total = total * t + 1.0 / factorial
    result = total * np.asarray((n.astype(np.int64) + 1023) << 52).view(np.float64)
    return np.select([np.isnan(y), y > 200.0, y < -200.0], [np.nan, np.inf, 0.0], result)


def sqrt(x: npt.ArrayLike) -> Array:
    """Return the IEEE square root."""
    with _quiet():
        return _single(np.sqrt(np.asarray(x, dtype=np.float32)))


def log2(x: npt.ArrayLike) -> Array:
    """Return the logarithm to base 2."""
    with _quiet():
        return _single(_log2(_double(x)))


def log(x: npt.ArrayLike) -> Array:
    """Return the natural logarithm."""
    with _quiet():
        return _single(_scaled_log(_double(x), 0.6931471805599453, 2.0))


def exp2(x: npt.ArrayLike) -> Array:
    """Return 2^x."""
    with _quiet():
        return _single(_exp2(_double(x)))


def exp(x: npt.ArrayLike) -> Array:
    """Return e^x."""
    with _quiet():
        return _single(_exp2(_double(x) * 1.4426950408889634))


def hypot(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return sqrt(a^2 + b^2)."""
    with _quiet():
        x, y = _double(a), _double(b)
        return _single(np.sqrt(x * x + y * y))


def pow(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return a^b with C's rules for zeros, infinities and negative bases."""
    with _quiet():
        x, y = np.broadcast_arrays(_double(a), _double(b))
        size = np.where(x < 0.0, -x, x)
        whole = np.floor(y) == y
        odd = whole & (np.floor(y * 0.5) != y * 0.5)
        power = np.where(size == 1.0, 1.0, _exp2(y * _log2(size)))
        result = np.where(odd & np.signbit(x), -power, power)
        undefined = np.isnan(y) | ((x < 0.0) & (size < np.inf) & ~whole)
        return _single(np.select([(y == 0.0) | (x == 1.0), undefined], [1.0, np.nan], result))


# Numbers of either kind --------------------------------------------------------------------------


def minimum(a: Array, b: Array) -> Array:
    """Return ``b < a ? b : a``."""
    return np.where(b < a, b, a)


def maximum(a: Array, b: Array) -> Array:
    """Return ``a < b ? b : a``."""
    return np.where(a < b, b, a)


def clamp(x: Array, low: Array, high: Array) -> Array:
    """Return x forced into [low, high]; NaN stays NaN."""
    return np.where(x < low, low, np.where(high < x, high, x))


def sign(x: Array) -> Array:
    """Return -1, 0 or 1 of x's kind; 0 for NaN."""
    result: Array = (x > 0).astype(x.dtype) - (x < 0).astype(x.dtype)
    return result


# Integers ----------------------------------------------------------------------------------------


def floordiv(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return the quotient rounded down; 0 for a zero divisor."""
    with _quiet():
        divisor = np.asarray(b, dtype=np.int64)
        quotient = np.asarray(a, dtype=np.int64) // np.where(divisor == 0, 1, divisor)
        return np.where(divisor == 0, 0, quotient).astype(_INT32)


def mod(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return a - b * floordiv(a, b), which has the divisor's sign; 0 for a zero divisor."""
    with _quiet():
        divisor = np.asarray(b, dtype=np.int64)
        rest = np.asarray(a, dtype=np.int64) % np.where(divisor == 0, 1, divisor)
        return np.where(divisor == 0, 0, rest).astype(_INT32)


def _saturate(whole: Array, low: int, high: int) -> Array:
    with _quiet():
        above_low = whole > low  # false for NaN, which gives low
        inside = np.where(above_low & (whole < high), whole, low).astype(np.int64)
        return np.where(above_low & ~(whole < high), high, inside).astype(_INT32)


def floor_to_int(x: npt.ArrayLike, low: int, high: int) -> Array:
    """Return floor(x) saturated to [low, high]; NaN gives low."""
    return _saturate(np.floor(_double(x)), low, high)


def ceil_to_int(x: npt.ArrayLike, low: int, high: int) -> Array:
    """Return ceil(x) saturated to [low, high]; NaN gives low."""
    return _saturate(np.ceil(_double(x)), low, high)


def round_to_int(x: npt.ArrayLike, low: int, high: int) -> Array:
    """Return x rounded half to even, saturated to [low, high]; NaN gives low."""
    return _saturate(np.rint(_double(x)), low, high)


# Fixed point and thresholds ----------------------------------------------------------------------


def saturate_fixed(x: Array) -> Array:
    """Return a fixed-point reward within the limits of a term and of a step's sum."""
    return np.minimum(np.maximum(x, -_FIXED_LIMIT), _FIXED_LIMIT)


def to_fixed(x: Array) -> Array:
    """Return a reward term in fixed point: floats half to even, saturated, 0 for NaN."""
    if x.dtype.kind != "f":
        return saturate_fixed(x.astype(np.int64) << FIXED_BITS)
    with _quiet():
        scaled = np.rint(_double(x) * 2.0**FIXED_BITS)
        limit = float(_FIXED_LIMIT)
        return np.where(np.isnan(scaled), 0.0, np.clip(scaled, -limit, limit)).astype(np.int64)


def from_fixed(x: npt.ArrayLike) -> Array:
    """Return a fixed-point reward as float32."""
    return _single(np.asarray(x, dtype=np.int64).astype(np.float64) * 2.0**-FIXED_BITS)


def threshold(p: npt.ArrayLike) -> Array:
    """Return T(p): a uniform 32-bit word is below it with probability p. In [0, 2^32]; 0 for NaN."""
    with _quiet():
        scaled = _double(p) * 2.0**32
        positive = np.where(scaled > 0.0, scaled, 0.0)
        return np.where(positive < 2.0**32, positive, 2.0**32).astype(np.uint64)


def canonical_bits(x: npt.ArrayLike) -> Array:
    """Return the bits of float32 values as uint32; every NaN gives the same ones."""
    single = np.asarray(x, dtype=np.float32)
    return np.where(np.isnan(single), np.uint32(0x7FC00000), single.view(np.uint32))
