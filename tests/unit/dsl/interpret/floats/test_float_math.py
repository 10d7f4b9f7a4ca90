# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from support.float_pairs import float_pairs

from hypgen.dsl.interpret.floats import exponentials as fe
from hypgen.dsl.interpret.floats import scalar_functions as fm


def real(function: Callable[..., float], *arguments: float) -> float:
    """Return what the real function gives as a double; C's value where Python raises."""
    try:
        return function(*arguments)
    except OverflowError:
        return -math.inf if function is math.pow and arguments[0] < 0 and arguments[1] % 2 == 1 else math.inf
    except ValueError:
        if function is math.pow and arguments[0] == 0:
            odd = arguments[1] % 2 == 1
            return math.copysign(math.inf, arguments[0]) if odd else math.inf
        return -math.inf if function in (math.log, math.log2) and arguments[0] == 0 else math.nan


def assert_within_one_ulp(got: npt.NDArray[np.float32], want: npt.NDArray[np.float64]) -> None:
    with np.errstate(over="ignore"):
        rounded = want.astype(np.float32)
        neighbours = [np.nextafter(rounded, np.float32(end)) for end in (-np.inf, np.inf)]
    same = fm.canonical_bits(got) == fm.canonical_bits(rounded)
    near = (got == neighbours[0]) | (got == neighbours[1])
    assert np.all(same | near), np.flatnonzero(~(same | near))[:5]
    assert np.count_nonzero(~same) <= len(got) * 1e-4


@pytest.mark.parametrize("name", ["exp", "exp2", "log", "log2", "sqrt"])
def test_functions_of_one_argument_are_within_one_ulp(name: str) -> None:
    x = float_pairs(20_000, 1)[:, 0]
    want = np.array([real(getattr(math, name), float(v)) for v in x])
    assert_within_one_ulp(getattr(fe, name)(x), want)


def test_pow_is_within_one_ulp_and_follows_c_at_the_edges() -> None:
    a, b = float_pairs(20_000, 2).T
    want = np.array([real(math.pow, float(u), float(v)) for u, v in zip(a, b, strict=True)])
    assert_within_one_ulp(fe.pow(a, b), want)


def test_hypot_is_within_one_ulp_where_finite() -> None:
    pairs = float_pairs(20_000, 3)
    a, b = pairs[np.isfinite(pairs).all(axis=1)].T
    assert_within_one_ulp(fe.hypot(a, b), np.hypot(a.astype(np.float64), b.astype(np.float64)))


def test_powers_of_two_and_small_integers_are_exact() -> None:
    n = np.arange(-149, 128, dtype=np.float32)
    assert np.array_equal(fe.exp2(n), 2.0 ** n.astype(np.float64))
    assert np.array_equal(fe.log2(fe.exp2(n)), n)
    base, power = np.meshgrid(np.arange(1, 11, dtype=np.float32), np.arange(0, 7, dtype=np.float32))
    assert np.array_equal(fe.pow(base, power), base.astype(np.float64) ** power)


def test_division_rounds_down_and_gives_0_for_a_zero_divisor() -> None:
    a, b = np.meshgrid(np.arange(-9, 10, dtype=np.int32), np.arange(-4, 5, dtype=np.int32))
    want = [
        [(x // y, x % y) if y else (0, 0) for x, y in zip(r, s, strict=True)]
        for r, s in zip(a, b, strict=True)
    ]
    assert np.array_equal(np.stack([fm.floordiv(a, b), fm.mod(a, b)], axis=-1), want)


def test_float_to_int_rounds_half_to_even_and_saturates() -> None:
    x = np.array([0.5, 1.5, -0.5, -1.5, 2.4, math.nan, math.inf, -math.inf, 3e9], dtype=np.float32)
    high = 2**31 - 1
    assert fm.round_to_int(x, -5, high).tolist() == [0, 2, 0, -2, 2, -5, high, -5, high]
    assert fm.floor_to_int(x, -5, 7).tolist() == [0, 1, -1, -2, 2, -5, 7, -5, 7]
    assert fm.ceil_to_int(x, -5, 7).tolist() == [1, 2, 0, -1, 3, -5, 7, -5, 7]


def test_rewards_are_exact_in_fixed_point() -> None:
    one = 2**24
    integers = np.array([3, -7, 2**31 - 1, -(2**31)], dtype=np.int32)
    assert fm.to_fixed(integers).tolist() == [3 * one, -7 * one, 2**48, -(2**48)]
    x = np.array([0.25, -0.1, 1.5 / one, 2.5 / one, 1e20, -math.inf, math.nan], dtype=np.float32)
    assert fm.to_fixed(x).tolist() == [one // 4, -1677722, 2, 2, 2**48, -(2**48), 0]
    assert fm.from_fixed(np.array([one // 4, -3 * one])).tolist() == [0.25, -3.0]


def test_masses_cover_the_whole() -> None:
    p = np.array([0.0, 0.5, 1.0, 2.0, -1.0, math.nan, 2.0**-63, 2.0**-64], dtype=np.float32)
    assert fm.mass(p).tolist() == [0, 2**62, 2**63, 2**63, 0, 0, 1, 0]
