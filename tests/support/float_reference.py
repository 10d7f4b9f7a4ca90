# SPDX-License-Identifier: Apache-2.0
"""What the float functions should give: MPFR's correctly rounded results, and how far off others are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import gmpy2
import numpy as np
import numpy.typing as npt

from hypgen.dsl.interpret.floats import exponentials as fe
from hypgen.dsl.interpret.floats import trigonometry as ft
from hypgen.dsl.interpret.floats.scalar_functions import canonical_bits

Floats = npt.NDArray[np.float32]
FLOAT32 = gmpy2.context(precision=24, emin=-148, emax=128, subnormalize=True)
PRECISE = gmpy2.context(precision=200)
SPECIAL = [
    *(0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0, np.inf, -np.inf, np.nan),
    *(1e-45, -1e-45, 1e-39, 1.1754944e-38, 3.4028235e38, -3.4028235e38, 0.99999994, -0.99999994, 1.0000001),
    *(
        88.72283,
        88.72284,
        -103.97,
        -103.98,
        128.0,
        -149.5,
        -150.0,
        0.7853982,
        1.5707964,
        3.1415927,
        16777216.0,
    ),
]


@dataclass(frozen=True)
class Function:
    """A float function in numpy, MPFR's, and the samples that are usual for it: exponents of ten."""

    ours: Callable[..., Any]
    exact: Callable[..., Any]
    arguments: int = 1
    usual: tuple[float, float] = (-4.0, 2.0)


FUNCTIONS = {
    "sqrt": Function(fe.sqrt, gmpy2.sqrt),
    "exp": Function(fe.exp, gmpy2.exp),
    "exp2": Function(fe.exp2, gmpy2.exp2),
    "log": Function(fe.log, gmpy2.log),
    "log2": Function(fe.log2, gmpy2.log2),
    "sin": Function(ft.sin, gmpy2.sin, usual=(-4.0, 7.0)),
    "cos": Function(ft.cos, gmpy2.cos, usual=(-4.0, 7.0)),
    "tan": Function(ft.tan, gmpy2.tan, usual=(-4.0, 7.0)),
    "asin": Function(ft.asin, gmpy2.asin, usual=(-4.0, 0.0)),
    "acos": Function(ft.acos, gmpy2.acos, usual=(-4.0, 0.0)),
    "pow": Function(fe.pow, pow, 2),
    "hypot": Function(fe.hypot, gmpy2.hypot, 2),
    "atan2": Function(ft.atan2, gmpy2.atan2, 2),
}


def samples(name: str, count: int, seed: int) -> list[Floats]:
    """Return a column of inputs for each argument: special, all bit patterns, usual sizes, hard cases."""
    function = FUNCTIONS[name]
    random = np.random.default_rng(seed)
    shape = (count // 2, function.arguments)
    patterns = random.integers(0, 2**32, shape, dtype=np.uint32).view(np.float32)
    sign = random.choice([-1.0, 1.0], shape)
    usual = (sign * 10.0 ** random.uniform(*function.usual, shape)).astype(np.float32)
    parts = [patterns, usual]
    if function.arguments == 1:
        parts.append(np.array([SPECIAL], dtype=np.float32).T)
        parts.append(
            np.concatenate([near_quarters(2000, random), np.float32([16367173.0 * 2.0**72])])[:, None]
        )
    else:
        parts.append(np.array([(a, b) for a in SPECIAL for b in SPECIAL], dtype=np.float32))
    rows = np.concatenate(parts)
    if name == "hypot":  # of NaN and an infinity it is NaN here, infinity elsewhere
        rows = rows[np.isfinite(rows).all(axis=1)]
    return [np.ascontiguousarray(column) for column in rows.T]


def near_quarters(count: int, random: np.random.Generator) -> Floats:
    """Return the floats nearest to multiples of pi/2 of every size: hard cases of the reduction."""
    with PRECISE:
        half_pi = gmpy2.const_pi() / 2
        sizes = random.uniform(0, 127, count)
        return np.array([float(half_pi * max(1, int(2.0**e))) for e in sizes], dtype=np.float32)


def correctly_rounded(name: str, columns: Sequence[Floats]) -> Floats:
    """Return MPFR's results, rounded once to float32."""
    exact = FUNCTIONS[name].exact
    with FLOAT32:
        rows = zip(*(map(float, column) for column in columns), strict=True)
        return np.array([float(exact(*map(gmpy2.mpfr, row))) for row in rows], dtype=np.float32)


def mistaken(name: str, columns: Sequence[Floats]) -> list[float]:
    """Return the errors in ulp of our results that are not correctly rounded; of others it is at most 1/2."""
    got, want = FUNCTIONS[name].ours(*columns), correctly_rounded(name, columns)
    wrong = np.flatnonzero(canonical_bits(got) != canonical_bits(want))
    return [error_in_ulp(name, [float(c[i]) for c in columns], float(got[i])) for i in wrong]


def error_in_ulp(name: str, row: Sequence[float], got: float) -> float:
    """Return how far ``got`` is from the exact value, in units of that value's last place."""
    with PRECISE:
        exact = FUNCTIONS[name].exact(*map(gmpy2.mpfr, row))
        exponent = max(int(gmpy2.floor(gmpy2.log2(abs(exact)))), -126)
        return float(abs(exact - gmpy2.mpfr(got)) / gmpy2.mpfr(2) ** (exponent - 23))
