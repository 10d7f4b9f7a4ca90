# SPDX-License-Identifier: Apache-2.0
"""The scalar functions of models on arrays: ``math/scalar_functions.hpp`` in numpy.

Float functions have modules of their own: ``exponentials``, ``trigonometry`` and ``normal``.
They are computed in float64 by a fixed sequence of IEEE + - * /, sqrt and floor and rounded once to float32.
Each function, here and there, is the header's function of the same name, operation by operation; change both
or neither. Where C++ branches, all lanes compute every branch and the right one is chosen, so floating-point
warnings mean nothing.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hypgen.dsl.interpret.floats.bits import Array, double, quiet, single

FIXED_BITS = 24
_FIXED_LIMIT = 2**48
WHOLE = np.uint64(2**63)  # the mass of all outcomes
_INT32 = np.int32

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
    with quiet():
        divisor = np.asarray(b, dtype=np.int64)
        quotient = np.asarray(a, dtype=np.int64) // np.where(divisor == 0, 1, divisor)
        return np.where(divisor == 0, 0, quotient).astype(_INT32)


def mod(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return a - b * floordiv(a, b), which has the divisor's sign; 0 for a zero divisor."""
    with quiet():
        divisor = np.asarray(b, dtype=np.int64)
        rest = np.asarray(a, dtype=np.int64) % np.where(divisor == 0, 1, divisor)
        return np.where(divisor == 0, 0, rest).astype(_INT32)


def _saturate(whole: Array, low: int, high: int) -> Array:
    with quiet():
        above_low = whole > low  # false for NaN, which gives low
        inside = np.where(above_low & (whole < high), whole, low).astype(np.int64)
        return np.where(above_low & ~(whole < high), high, inside).astype(_INT32)


def floor_to_int(x: npt.ArrayLike, low: int, high: int) -> Array:
    """Return floor(x) saturated to [low, high]; NaN gives low."""
    return _saturate(np.floor(double(x)), low, high)


def ceil_to_int(x: npt.ArrayLike, low: int, high: int) -> Array:
    """Return ceil(x) saturated to [low, high]; NaN gives low."""
    return _saturate(np.ceil(double(x)), low, high)


def round_to_int(x: npt.ArrayLike, low: int, high: int) -> Array:
    """Return x rounded half to even, saturated to [low, high]; NaN gives low."""
    return _saturate(np.rint(double(x)), low, high)


# Fixed point and masses --------------------------------------------------------------------------


def saturate_fixed(x: Array) -> Array:
    """Return a fixed-point reward within the limits of a term and of a step's sum."""
    return np.minimum(np.maximum(x, -_FIXED_LIMIT), _FIXED_LIMIT)


def to_fixed(x: Array, bits: int = FIXED_BITS) -> Array:
    """Return a reward term in fixed point: half to even, saturated, 0 for NaN."""
    with quiet():
        scaled = np.rint(x.astype(np.float64) * 2.0**bits)
        limit = float(_FIXED_LIMIT)
        return np.where(np.isnan(scaled), 0.0, np.clip(scaled, -limit, limit)).astype(np.int64)


def from_fixed(x: npt.ArrayLike, bits: int = FIXED_BITS) -> Array:
    """Return a fixed-point reward as float32."""
    return single(np.asarray(x, dtype=np.int64).astype(np.float64) * 2.0**-bits)


def mass(p: npt.ArrayLike) -> Array:
    """Return M(p): 63 random bits are below it with probability p. In [0, 2^63]; 0 for NaN."""
    with quiet():
        scaled = double(p) * 2.0**63
        positive = np.where(scaled > 0.0, scaled, 0.0)
        return np.where(positive < 2.0**63, positive, 2.0**63).astype(np.uint64)


def share_of(mass: npt.ArrayLike) -> Array:
    """Return the probability of a mass."""
    return np.asarray(mass).astype(np.float64) * 2.0**-63


def after(until: Array, mass: Array) -> Array:
    """Return where a mass that starts at ``until`` ends: not beyond the whole."""
    return until + np.minimum(mass, WHOLE - until)


def part(weight: Array, scale: Array) -> Array:
    """Return the mass of a weight; 0 where that is not finite."""
    found = weight.astype(np.float64) * scale
    return np.where(found < 2.0**63, found, 0.0).astype(np.uint64)


def canonical_bits(x: npt.ArrayLike) -> Array:
    """Return the bits of float32 values as uint32; every NaN gives the same ones."""
    single = np.asarray(x, dtype=np.float32)
    return np.where(np.isnan(single), np.uint32(0x7FC00000), single.view(np.uint32))


def canonical_double_bits(x: Array) -> Array:
    """Return the bits of float64 values as uint64; every NaN gives the same ones."""
    return np.where(np.isnan(x), np.uint64(0x7FF8000000000000), np.ascontiguousarray(x).view(np.uint64))
