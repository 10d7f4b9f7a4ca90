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


def lane_flags() -> dict[str, list[str]]:
    """Return the flags of a model's lanes for each kind of processor, by its name, the widest kind first.

    The namespace hypgen has another name in each: no other code may call what these flags have made.
    """
    lines = (CMAKE_FOLDER / "lanes.txt").read_text(encoding="utf-8").splitlines()
    kinds = [line.split() for line in lines]
    return {
        name: [f"-march={architecture}", f"-Dhypgen=hypgen_{name}", f"-DHYPGEN_LANES={name}", "-Wno-psabi"]
        for name, architecture in kinds
    }


def _words(name: str) -> list[str]:
    return (CMAKE_FOLDER / name).read_text(encoding="utf-8").split()
