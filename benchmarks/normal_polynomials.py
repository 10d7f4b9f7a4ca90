# SPDX-License-Identifier: Apache-2.0
"""Prints the coefficients of the normal law: ``normal.hpp`` and ``dsl/interpret/floats/normal.py`` have them.

Needs gmpy2 (the test extra). Both functions are interpolated at 60 Chebyshev nodes with 300 bits; the first
terms of the Chebyshev series, as many as reach 2^-52, are rewritten in powers, highest first, and rounded to
double.

    python benchmarks/normal_polynomials.py
"""

from __future__ import annotations

from collections.abc import Callable

import gmpy2
from gmpy2 import mpfr

NODES = 60
Function = Callable[[mpfr], mpfr]


def chebyshev(function: Function, low: float, high: float) -> list[mpfr]:
    """Return the terms of the Chebyshev series that interpolates ``function`` on [low, high]."""
    angles = [gmpy2.const_pi() * (2 * k + 1) / (2 * NODES) for k in range(NODES)]
    middle, half = mpfr(low + high) / 2, mpfr(high - low) / 2
    values = [function(middle + half * gmpy2.cos(angle)) for angle in angles]
    sums = [
        sum(v * gmpy2.cos(j * a) for v, a in zip(values, angles, strict=True)) / NODES for j in range(NODES)
    ]
    return [sums[0], *(2 * s for s in sums[1:])]


def powers(series: list[mpfr]) -> list[mpfr]:
    """Return a Chebyshev series as a polynomial, the constant first."""
    total = [mpfr(0)] * len(series)
    last, current = [mpfr(0)], [mpfr(1)]
    for order, term in enumerate(series):
        for i, c in enumerate(current):
            total[i] += term * c
        following = [mpfr(0), *((1 if order == 0 else 2) * c for c in current)]
        for i, c in enumerate(last if order else []):
            following[i] -= c
        last, current = current, following
    return total


def upper_tail(x: mpfr) -> mpfr:
    """Return P(X > x) of a standard normal X."""
    return gmpy2.erfc(x / gmpy2.sqrt(mpfr(2))) / 2


def scaled_tail(t: mpfr) -> mpfr:
    """Return (1 + x) P(X > x) e^(x^2 / 2) for t = (x - 5) / (x + 5)."""
    x = 5 * (1 + t) / (1 - t)
    return upper_tail(x) * gmpy2.exp(x * x / 2) * (1 + x)


def quantile_over_distance(w: mpfr) -> mpfr:
    """Return x / (1/2 - p) for P(X > x) = p < 1/2 and w = -log(4 p (1 - p)), by Newton's method on log p."""
    distance = gmpy2.sqrt(-gmpy2.expm1(-w)) / 2
    log_p = -w - gmpy2.log(4 * (mpfr(0.5) + distance))
    x = distance * gmpy2.sqrt(2 * gmpy2.const_pi())
    for _ in range(80):
        tail = upper_tail(x)
        slope = gmpy2.exp(-x * x / 2) / gmpy2.sqrt(2 * gmpy2.const_pi()) / tail
        x += (gmpy2.log(tail) - log_p) / slope
    return x / distance


def main() -> None:
    """Print both polynomials."""
    with gmpy2.context(precision=300):
        for name, series in (
            ("kTerms of scaled_tail", chebyshev(scaled_tail, -1.0, 1.0)[:23]),
            ("kTerms of normal_quantile", chebyshev(quantile_over_distance, 0.0, 6.25)[:22]),
        ):
            print(name)
            for term in reversed(powers(series)):
                print(f"  {float(term)!r}")


if __name__ == "__main__":
    main()
