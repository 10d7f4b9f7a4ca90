# SPDX-License-Identifier: Apache-2.0
"""Compare all 2^32 inputs of each one-argument float function between numpy, the host and a GPU.

    python benchmarks/all_floats.py                # all functions; a GPU and nvcc are used if they are there
    python benchmarks/all_floats.py sin cos        # some

Each program hashes the results of 2^20 inputs at a time (tests/support/float_hash_main.cpp says how); a
chunk whose hashes differ has at least one input whose bits differ. All cores work; one function takes ten
to twenty minutes of one core.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from hypgen.dsl.interpret.floats import exponentials, trigonometry
from hypgen.dsl.interpret.floats.scalar_functions import canonical_bits
from hypgen.runtime.builder.compile_flags import host_flags, nvcc_flags

ROOT = Path(__file__).resolve().parent.parent
FUNCTIONS = ("sqrt", "exp", "exp2", "log", "log2", "sin", "cos", "tan", "asin", "acos")
CHUNK, CHUNKS, BLOCK, TASK = 2**20, 2**12, 2**14, 2**5


def numpy_hash(name: str, chunk: int) -> int:
    """Return the hash of one chunk; blocks are small enough for the cache."""
    module = exponentials if hasattr(exponentials, name) else trigonometry
    function = getattr(module, name)
    total = np.uint64(0)
    with np.errstate(all="ignore"):
        for start in range(0, CHUNK, BLOCK):
            place = np.arange(start, start + BLOCK, dtype=np.uint64)
            x = (place + np.uint64(chunk * CHUNK)).astype(np.uint32).view(np.float32)
            bits = canonical_bits(function(x)).astype(np.uint64)
            weights = (np.uint64(2) * place + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
            total += np.sum((bits + np.uint64(1)) * weights, dtype=np.uint64)
    return int(total)


def numpy_hashes(task: tuple[str, int]) -> list[int]:
    """Return the hashes of the chunks of one task."""
    name, first = task
    return [numpy_hash(name, chunk) for chunk in range(first, first + TASK)]


def program_hashes(task: tuple[str, str, int, int]) -> list[int]:
    """Return what one of the programs says of ``count`` chunks."""
    program, name, first, count = task
    run = subprocess.run([program, name, str(first), str(count)], check=True, capture_output=True, text=True)
    return [int(line, 16) for line in run.stdout.split()]


def build(compiler: str, flags: list[str], source: Path, folder: str) -> str:
    """Compile ``source`` and return the program's path."""
    program = str(Path(folder) / source.stem)
    include = f"-I{ROOT / 'runtime' / 'include'}"
    subprocess.run([compiler, *flags, include, str(source), "-o", program], check=True)
    return program


def main() -> None:
    """Build both programs, compare, and print a line for each function."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("functions", nargs="*", default=FUNCTIONS, help="default: all")
    names = parser.parse_args().functions
    with tempfile.TemporaryDirectory() as folder, multiprocessing.Pool(os.cpu_count()) as pool:
        flags = ["-std=c++17", "-O3", *host_flags()]
        host = build("g++", flags, ROOT / "tests" / "support" / "float_hash_main.cpp", folder)
        device = ""
        if shutil.which("nvcc") and shutil.which("nvidia-smi"):
            flags = [*nvcc_flags(), "-arch=native", "-cudart=static"]
            device = build("nvcc", flags, ROOT / "benchmarks" / "all_floats.cu", folder)
        print(
            "| function | chunks of 2^20 | host differs | GPU differs | seconds |\n|---|---|---|---|---|",
            flush=True,
        )
        wrong = 0
        for name in names:
            start = time.monotonic()
            firsts = range(0, CHUNKS, TASK)
            expected = [h for part in pool.imap(numpy_hashes, [(name, f) for f in firsts]) for h in part]
            tasks = [(host, name, f, TASK) for f in firsts]
            on_host = [h for part in pool.imap(program_hashes, tasks) for h in part]
            on_device = program_hashes((device, name, 0, CHUNKS)) if device else None
            differ = sum(a != b for a, b in zip(expected, on_host, strict=True))
            wrong += differ
            told = "not run"
            if on_device is not None:
                others = sum(a != b for a, b in zip(expected, on_device, strict=True))
                wrong += others
                told = str(others)
            seconds = time.monotonic() - start
            print(f"| {name} | {CHUNKS} | {differ} | {told} | {seconds:.0f} |", flush=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
