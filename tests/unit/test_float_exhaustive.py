"""All 2^32 inputs of the float functions of one argument: numpy and the header give the same bits.

The long test takes 10 to 20 minutes of one core for each function: ``pytest -m slow -k all_inputs``.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from float_reference import FUNCTIONS

from hypgen.dsl.interpret.floats.scalar_functions import canonical_bits
from hypgen.runtime.builder.compile_flags import host_flags

HERE = Path(__file__).parent
INCLUDE = HERE.parent.parent / "runtime" / "include"
CHUNK, CHUNKS, BLOCK = 2**20, 2**12, 2**14
ONE_ARGUMENT = [name for name, function in FUNCTIONS.items() if function.arguments == 1]
# Zeros, small and large, the ends of the first octaves, infinities and NaN, both signs.
FEW = [0, 0x3F0, 0x3F8, 0x49F, 0x7F7, 0x7F8, 0x800, 0xBF7, 0xC2C, 0xFF8]

needs_compiler = pytest.mark.skipif(shutil.which("g++") is None, reason="needs a C++ compiler (g++)")


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("float_hash") / "float_hash"
    flags = ["-std=c++17", "-O3", *host_flags(), "-Wall", "-Wextra", "-Wconversion", "-Werror"]
    subprocess.run(
        ["g++", *flags, f"-I{INCLUDE}", str(HERE / "float_hash_main.cpp"), "-o", str(path)], check=True
    )
    return str(path)


def hash_of_chunk(name: str, chunk: int) -> int:
    """Return the hash that ``float_hash_main.cpp`` defines; blocks are small enough for the cache."""
    total = np.uint64(0)
    with np.errstate(over="ignore"):
        for start in range(0, CHUNK, BLOCK):
            place = np.arange(start, start + BLOCK, dtype=np.uint64)
            x = (place + np.uint64(chunk * CHUNK)).astype(np.uint32).view(np.float32)
            bits = canonical_bits(FUNCTIONS[name].ours(x)).astype(np.uint64)
            weights = (np.uint64(2) * place + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
            total += np.sum((bits + np.uint64(1)) * weights, dtype=np.uint64)
    return int(total)


def differing_chunks(program: str, name: str, first: int, count: int) -> list[str]:
    """Return the first bit patterns of the chunks whose hashes differ."""
    run = subprocess.run([program, name, str(first), str(count)], check=True, capture_output=True, text=True)
    pairs = zip(range(first, first + count), run.stdout.split(), strict=True)
    return [f"0x{chunk * CHUNK:08x}" for chunk, text in pairs if int(text, 16) != hash_of_chunk(name, chunk)]


@needs_compiler
@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_chunks_of_every_kind(program: str, name: str) -> None:
    assert [c for chunk in FEW for c in differing_chunks(program, name, chunk, 1)] == []


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("name", ONE_ARGUMENT)
def test_all_inputs(program: str, name: str) -> None:
    assert differing_chunks(program, name, 0, CHUNKS) == []
