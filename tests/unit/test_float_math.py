from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from hypgen.dsl.interpret.floats import exponentials as fe
from hypgen.dsl.interpret.floats import normal as fn
from hypgen.dsl.interpret.floats import scalar_functions as fm
from hypgen.dsl.interpret.floats import trigonometry as ft
from hypgen.runtime.builder.compile_flags import host_flags

HERE = Path(__file__).parent
INCLUDE = HERE.parent.parent / "runtime" / "include"
EDGES = [
    *(0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0, 1e-45, -1e-45, 1e-38, 1.1754944e-38),
    *(3.4028235e38, -3.4028235e38, math.inf, -math.inf, math.nan, 88.72283, 88.72284, -103.97, -103.98),
    *(128.0, 127.99999, -149.0, -149.5, -150.0, 0.99999994, 1.0000001, 1.4142135, 1.4142137, 0.70710677),
    *(2147483648.0, -2147483648.0, 16777216.0, 4294967296.0, 1000.5, -100.5, 2.5, -2.5, 1e30),
    *(0.7853982, 1.5707964, 3.1415927, 1048576.0, 1048576.1, 16367173.0, 6.0e37, 37.2, -37.3, 1e-39),
]


def samples(count: int, seed: int) -> npt.NDArray[np.float32]:
    """Every edge with every edge, all bit patterns, and the magnitudes that models use."""
    random = np.random.default_rng(seed)
    patterns = random.integers(0, 2**32, (count // 2, 2), dtype=np.uint32).view(np.float32)
    usual = (random.normal(0, 1, (count // 2, 2)) * 10.0 ** random.uniform(-4, 2, (count // 2, 2))).astype(
        "f4"
    )
    small_powers = usual.copy()
    small_powers[:, 1] = np.rint(small_powers[:, 1])
    edges = np.array([(a, b) for a in EDGES for b in EDGES], dtype=np.float32)
    return np.concatenate([edges, patterns, usual, small_powers])


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
    x = samples(20_000, 1)[:, 0]
    want = np.array([real(getattr(math, name), float(v)) for v in x])
    assert_within_one_ulp(getattr(fe, name)(x), want)


def test_pow_is_within_one_ulp_and_follows_c_at_the_edges() -> None:
    a, b = samples(20_000, 2).T
    want = np.array([real(math.pow, float(u), float(v)) for u, v in zip(a, b, strict=True)])
    assert_within_one_ulp(fe.pow(a, b), want)


def test_hypot_is_within_one_ulp_where_finite() -> None:
    pairs = samples(20_000, 3)
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


def test_thresholds_cover_all_words() -> None:
    p = np.array([0.0, 0.5, 1.0, 2.0, -1.0, math.nan, 2.0**-32, 2.0**-33], dtype=np.float32)
    assert fm.threshold(p).tolist() == [0, 2**31, 2**32, 2**32, 0, 0, 1, 0]


def expected_columns(pairs: npt.NDArray[np.float32]) -> list[npt.NDArray[np.int64]]:
    """Return what ``float_math_main.cpp`` writes, column by column."""
    a, b = pairs.T
    i, j = pairs.view(np.int32).T
    words = pairs.view(np.uint32).astype(np.int64)
    divisor = np.fmod(j, np.int32(17))
    low, high = np.float32(-1.5), np.float32(2.0)
    floats = [
        *(fe.exp(a), fe.exp2(a), fe.log(a), fe.log2(a), fe.sqrt(a), fe.pow(a, b), fe.hypot(a, b), np.abs(a)),
        *(fm.sign(a), fm.minimum(a, b), fm.maximum(a, b), fm.clamp(a, low, high)),
        *(ft.sin(a), ft.cos(a), ft.tan(a), ft.asin(a), ft.acos(a), ft.atan2(a, b)),
        fm.from_fixed(words[:, 0] * 65537 - words[:, 1]),
    ]
    ints = [
        *(fm.floordiv(i, j), fm.mod(i, j), fm.floordiv(i, divisor), fm.mod(i, divisor)),
        *(fm.floor_to_int(a, -100, 1000), fm.ceil_to_int(a, -100, 1000)),
        *(
            fm.round_to_int(a, -(2**31), 2**31 - 1),
            fm.sign(i),
            fm.to_fixed(a),
            fm.to_fixed(i),
            fm.threshold(a),
        ),
    ]
    doubles = [
        *(fn.normal_cdf(a), fn.normal_quantile(a), fn.normal_of_word(words[:, 0])),
        fn.exponential_of_word(words[:, 0]),
    ]
    return [
        *(fm.canonical_bits(x).astype(np.int64) for x in floats),
        *(x.astype(np.int64) for x in ints),
        *(np.where(np.isnan(x), 0, x.view(np.int64)) for x in doubles),
    ]


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs a C++ compiler (g++)")
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_the_header_gives_the_same_bits(level: str, tmp_path: Path) -> None:
    pairs = samples(800_000, 4)
    pairs.tofile(tmp_path / "in")
    flags = ["-std=c++17", level, "-march=native", *host_flags()]
    warnings = ["-Wall", "-Wextra", "-Wconversion", "-Werror"]
    program = str(tmp_path / "float_math")
    source = str(HERE / "float_math_main.cpp")
    subprocess.run(["g++", *flags, *warnings, f"-I{INCLUDE}", source, "-o", program], check=True)
    subprocess.run([program, tmp_path / "in", tmp_path / "out"], check=True)
    got = np.fromfile(tmp_path / "out", dtype=np.int64).reshape(len(pairs), -1)
    for column, want in enumerate(expected_columns(pairs)):
        wrong = np.flatnonzero(got[:, column] != want)
        assert not len(wrong), (column, pairs[wrong[0]], got[wrong[0], column], want[wrong[0]])
