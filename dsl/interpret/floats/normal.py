# SPDX-License-Identifier: Apache-2.0
"""The normal law and the exponential law in float64: ``math/normal.hpp`` in numpy.

Each function is the header's of the same name, operation by operation. The polynomials interpolate at
Chebyshev nodes; ``benchmarks/normal_polynomials.py`` computes them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hypgen.dsl.interpret.floats.bits import Array, quiet
from hypgen.dsl.interpret.floats.exponentials import exp2_inside, log_double

_TAIL = (
    *(-2.8220772290629865e-10, 2.2070652717459774e-09, 3.627373163401201e-09, -2.54667816805072e-08),
    *(-2.6286205089898754e-08, 1.8846163807542468e-07, 1.27878221820937e-07, -1.3004549261799018e-06),
    *(-7.034644683537101e-08, 9.055745037072721e-06, -9.896097759279782e-06, -5.360602125091952e-05),
    *(0.00018233414511643843, 7.79121440702919e-06, -0.00167607234455447, 0.0065220007252342425),
    *(-0.015170415402514863, 0.024536963238891124, -0.026401042966308307, 0.010002352385413518),
    *(0.031030368425963708, -0.09155228183401112, 0.46151582985003775),
)
_MIDDLE = (
    *(-1.171368925093117e-08, 2.432521432742981e-08, 7.948232979900164e-08, -2.942392415548481e-07),
    *(1.5743442299138234e-08, 1.5390545633214804e-06, -3.0360753856234887e-06, -1.941437108416409e-06),
    *(2.0190100343985194e-05, -3.183769505604272e-05, -4.2513674685119e-05, 0.0002640822038657141),
    *(-0.00033060938238705837, -0.0007478181314084803, 0.0034859952858551997, -0.0035968889130826662),
    *(-0.011702092181392638, 0.05036965361434562, -0.06393503231828694, -0.16665818705600238),
    *(2.12271849188213, 4.677241420053186),
)


def _polynomial(t: Array, terms: tuple[float, ...]) -> Array:
    total: Array = np.full_like(t, terms[0])
    for term in terms[1:]:
        total = total * t + term
    return total


def _scaled_tail(x: Array) -> Array:
    return _polynomial((x - 5.0) / (x + 5.0), _TAIL) / (1.0 + x)


def _tail_quantile(p: Array) -> Array:
    depth = -log_double(p)
    square = 2.0 * depth - 1.8378770664093456
    x = np.sqrt(square - log_double(square))
    for _ in range(3):
        scaled = _scaled_tail(x)
        excess = x * x * 0.5 - log_double(scaled) - depth
        x = x - excess * scaled * 2.5066282746310007
    return x


def normal_cdf(x: npt.ArrayLike) -> Array:
    """Return P(X <= x) of a standard normal X; 0 below -37.2, NaN for NaN."""
    with quiet():
        y = np.asarray(x, dtype=np.float64)
        size = np.abs(y)
        power = size * size * -0.7213475204444817
        cut = ~(power >= -1000.0)
        tail = exp2_inside(np.where(cut, 0.0, power)) * _scaled_tail(np.where(cut, 0.0, size))
        tail = np.where(cut, 0.0, tail)
        return np.select([np.isnan(y), y == 0.0, y > 0.0], [np.nan, 0.5, 1.0 - tail], tail)


def normal_quantile(p: npt.ArrayLike) -> Array:
    """Return the x with P(X <= x) = p of a standard normal X.

    0 and subnormal p give -infinity, 1 gives infinity, what is no probability NaN.
    """
    with quiet():
        q = np.asarray(p, dtype=np.float64)
        rest = 1.0 - q
        w = -log_double(4.0 * q * rest)
        middle = (q - 0.5) * _polynomial(w * 0.32 - 1.0, _MIDDLE)
        lower = q < 0.5
        tail = w > 6.25
        far = _tail_quantile(np.where(tail, np.where(lower, q, rest), 0.0001))
        result = np.where(tail, np.where(lower, -far, far), middle)
        special = [~((q >= 0.0) & (q <= 1.0)), q < 2.2250738585072014e-308, rest == 0.0]
        return np.select(special, [np.nan, -np.inf, np.inf], result)


def unit_of_word(w: npt.ArrayLike) -> Array:
    """Return the middle of the w-th of 2^32 equal parts of (0, 1); exact."""
    result: Array = (np.asarray(w).astype(np.float64) + 0.5) * 2.0**-32
    return result


def normal_of_word(w: npt.ArrayLike) -> Array:
    """Return a standard normal number: the lower tail's quantile of 31 bits, negated by the top bit."""
    word = np.asarray(w).astype(np.int64)
    x = normal_quantile(unit_of_word(word & 0x7FFFFFFF))
    return np.where(word >> 31 != 0, -x, x)


def exponential_of_word(w: npt.ArrayLike) -> Array:
    """Return an exponential number of mean 1."""
    with quiet():
        return -log_double(unit_of_word(w))
