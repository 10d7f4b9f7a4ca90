# SPDX-License-Identifier: Apache-2.0
"""The float functions of numpy and of the C++ headers give the same bits.

All 2^32 inputs of a function of one argument take 10 to 20 minutes of one core:
``pytest -m slow -k all_inputs``.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from support.float_pairs import float_pairs
from support.float_reference import FUNCTIONS
from support.paths import ROOT

from hypgen.dsl.interpret.floats import exponentials as fe
from hypgen.dsl.interpret.floats import normal as fn
from hypgen.dsl.interpret.floats import scalar_functions as fm
from hypgen.dsl.interpret.floats import trigonometry as ft
from hypgen.runtime.builder.compile_flags import host_flags

INCLUDE = ROOT / "runtime" / "include"
MAIN = ROOT / "tests" / "support" / "float_hash_main.cpp"
CHUNK, CHUNKS, BLOCK = 2**20, 2**12, 2**14
ONE_ARGUMENT = [name for name, function in FUNCTIONS.items() if function.arguments == 1]
# Zeros, small and large, the ends of the first octaves, infinities and NaN, both signs.
FEW = [0, 0x3F0, 0x3F8, 0x49F, 0x7F7, 0x7F8, 0x800, 0xBF7, 0xC2C, 0xFF8]

pytestmark = [
    pytest.mark.cxx,
    pytest.mark.skipif(shutil.which("g++") is None, reason="needs a C++ compiler (g++)"),
]


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("float_hash") / "float_hash"
    flags = ["-std=c++17", "-O3", *host_flags(), "-Wall", "-Wextra", "-Wconversion", "-Werror"]
    subprocess.run(["g++", *flags, f"-I{INCLUDE}", str(MAIN), "-o", str(path)], check=True)
    return str(path)


def hash_of_chunk(name: str, chunk: int) -> int:
    """Return the hash that ``float_hash_main.cpp`` defines; blocks are small enough for the cache."""
    total = np.uint64(0)
    with np.errstate(over="ignore"):
        for start in range(0, CHUNK, BLOCK):
            place = np.arange(start, start + BLOCK, dtype=np.uint64)
            x = (place + np.uint64(chunk * CHUNK)).astype(np.uint32).view(np.float32)
            bits = fm.canonical_bits(FUNCTIONS[name].ours(x)).astype(np.uint64)
            weights = (np.uint64(2) * place + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
            total += np.sum((bits + np.uint64(1)) * weights, dtype=np.uint64)
    return int(total)


def differing_chunks(program: str, name: str, first: int, count: int) -> list[str]:
    """Return the first bit patterns of the chunks whose hashes differ."""
    run = subprocess.run([program, name, str(first), str(count)], check=True, capture_output=True, text=True)
    pairs = zip(range(first, first + count), run.stdout.split(), strict=True)
    return [f"0x{chunk * CHUNK:08x}" for chunk, text in pairs if int(text, 16) != hash_of_chunk(name, chunk)]


@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_chunks_of_every_kind(program: str, name: str) -> None:
    assert [c for chunk in FEW for c in differing_chunks(program, name, chunk, 1)] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_all_inputs(program: str, name: str) -> None:
    assert differing_chunks(program, name, 0, CHUNKS) == []


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
        *(fm.from_fixed(words[:, 0] * 65537 - words[:, 1], bits) for bits in (24, -9)),
    ]
    ints = [
        *(fm.floordiv(i, j), fm.mod(i, j), fm.floordiv(i, divisor), fm.mod(i, divisor)),
        *(fm.floor_to_int(a, -100, 1000), fm.ceil_to_int(a, -100, 1000)),
        *(
            fm.round_to_int(a, -(2**31), 2**31 - 1),
            fm.sign(i),
            fm.to_fixed(a),
            fm.to_fixed(i),
            *(fm.to_fixed(x, bits) for bits in (-9, 50) for x in (a, i)),
            fm.mass(a),
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


@pytest.mark.parametrize("level", [pytest.param("-O0", marks=pytest.mark.unoptimised), "-O3"])
def test_the_header_gives_the_same_bits(level: str, tmp_path: Path) -> None:
    pairs = float_pairs(800_000, 4)
    pairs.tofile(tmp_path / "in")
    flags = ["-std=c++17", level, "-march=native", *host_flags()]
    warnings = ["-Wall", "-Wextra", "-Wconversion", "-Werror"]
    program = str(tmp_path / "float_math")
    source = str(Path(__file__).parent / "float_math_main.cpp")
    subprocess.run(["g++", *flags, *warnings, f"-I{INCLUDE}", source, "-o", program], check=True)
    subprocess.run([program, tmp_path / "in", tmp_path / "out"], check=True)
    got = np.fromfile(tmp_path / "out", dtype=np.int64).reshape(len(pairs), -1)
    for column, want in enumerate(expected_columns(pairs)):
        wrong = np.flatnonzero(got[:, column] != want)
        assert not len(wrong), (column, pairs[wrong[0]], got[wrong[0], column], want[wrong[0]])
