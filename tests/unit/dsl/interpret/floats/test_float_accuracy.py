# SPDX-License-Identifier: Apache-2.0
"""Functions against MPFR: special values, hard cases and samples of each float function."""

from __future__ import annotations

import gmpy2
import numpy as np
import pytest
from support.float_reference import FUNCTIONS, PRECISE, mistaken, samples

from hypgen.dsl.interpret.floats import normal as fn

# Of each function; the last is the size that docs/results/float_functions.md answers for.
SIZES = [10_000, pytest.param(200_000, marks=pytest.mark.property)]


@pytest.mark.parametrize("count", SIZES)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_within_one_ulp_and_nearly_always_correctly_rounded(name: str, count: int) -> None:
    errors = mistaken(name, samples(name, count, seed=7))
    assert len(errors) <= 2
    assert max(errors, default=0.0) < 0.5001


def lower_tail(x: float) -> gmpy2.mpfr:
    return gmpy2.erfc(-gmpy2.mpfr(x) / gmpy2.sqrt(gmpy2.mpfr(2))) / 2


@pytest.mark.parametrize("count", [2_000, pytest.param(20_000, marks=pytest.mark.property)])
def test_the_normal_distribution_function(count: int) -> None:
    random = np.random.default_rng(8)
    x = np.concatenate([random.uniform(-37, 9, count // 2), random.normal(0, 1, count)])
    with PRECISE:
        errors = [abs(float((lower_tail(a) - b) / b)) for a, b in zip(x, fn.normal_cdf(x), strict=True)]
    assert max(errors) < 2.0**-43
    assert max(errors[count // 2 :]) < 2.0**-49
    assert fn.normal_cdf([-np.inf, -38.0, 0.0, 9.0, np.inf]).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert np.isnan(fn.normal_cdf(np.nan))


def quantile_error(p: float, x: float) -> float:
    """Return the relative error of x as the quantile of p, to first order."""
    with PRECISE:
        density = gmpy2.exp(-(gmpy2.mpfr(x) ** 2) / 2) / gmpy2.sqrt(2 * gmpy2.const_pi())
        return abs(float((lower_tail(x) - gmpy2.mpfr(p)) / density / x))


@pytest.mark.parametrize("count", [1_000, pytest.param(8_000, marks=pytest.mark.property)])
def test_the_normal_quantile(count: int) -> None:
    random = np.random.default_rng(9)
    p = np.concatenate(
        [
            10.0 ** random.uniform(-307, 0, count),
            random.uniform(0, 1, count),
            1.0 - 10.0 ** random.uniform(-12, 0, count // 2),
        ]
    )
    errors = [quantile_error(float(a), float(b)) for a, b in zip(p, fn.normal_quantile(p), strict=True)]
    assert max(errors) < 2.0**-50
    assert fn.normal_quantile([0.0, 0.5, 1.0]).tolist() == [-np.inf, 0.0, np.inf]
    assert np.isnan(fn.normal_quantile([-1e-9, 1.1, np.nan])).all()


def test_words_become_normal_and_exponential_numbers() -> None:
    words = np.random.default_rng(10).integers(0, 2**32, 1_000_000, dtype=np.uint32)
    normal, exponential = fn.normal_of_word(words), fn.exponential_of_word(words)
    assert abs(normal.mean()) < 0.005 and abs(normal.std() - 1.0) < 0.005
    assert np.array_equal(normal, -fn.normal_of_word(words ^ np.uint32(2**31)))
    assert abs(exponential.mean() - 1.0) < 0.005 and abs(exponential.std() - 1.0) < 0.005
    for word in (0, 1, 2**31 - 1, 2**31, 2**32 - 1):
        with PRECISE:
            want = -gmpy2.log((gmpy2.mpfr(word) + 0.5) / 2**32)
            assert abs(float(fn.exponential_of_word(word) / want) - 1.0) < 2.0**-50
    assert abs(fn.normal_of_word(0)) < 6.34 and abs(fn.normal_of_word(2**31 - 1)) < 3e-10
