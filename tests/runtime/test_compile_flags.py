# SPDX-License-Identifier: Apache-2.0
"""The flags on which equal bits rest stand in one place, which CMake and Python read."""

from pathlib import Path

from hypgen.runtime.builder.compile_flags import host_flags, nvcc_flags

ROOT = Path(__file__).parents[2]
FOLDERS = ("runtime", "codegen", "cli", "dsl", "tests", "benchmarks")
TYPES = {".py", ".txt", ".cmake", ".j2", ".hpp", ".cuh", ".cpp", ".cu", ".md"}


def test_no_other_file_names_them() -> None:
    names = [f"{flag.split('=')[0]}=" for flag in (*host_flags(), *nvcc_flags()) if "-f" in flag[:4]]
    assert names == ["-ffp-contract=", "--fmad=", "--ftz="]
    found = {
        path.relative_to(ROOT).as_posix()
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.suffix in TYPES and path != Path(__file__)
        for name in names
        if name in path.read_text(encoding="utf-8")
    }
    assert found == {"runtime/cmake/host_flags.txt", "runtime/cmake/nvcc_flags.txt"}
