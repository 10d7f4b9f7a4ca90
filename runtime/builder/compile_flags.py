# SPDX-License-Identifier: Apache-2.0
"""The compiler flags on which equal bits rest: files that the runtime's CMake code reads too."""

from pathlib import Path

CMAKE_FOLDER = Path(__file__).parent.parent / "cmake"


def host_flags() -> list[str]:
    """Return the flags without which a C++ compiler gives results with other bits."""
    return _words("host_flags.txt")


def nvcc_flags() -> list[str]:
    """Return the flags of every nvcc command, the host compiler's left out."""
    return _words("nvcc_flags.txt")


def _words(name: str) -> list[str]:
    return (CMAKE_FOLDER / name).read_text(encoding="utf-8").split()
