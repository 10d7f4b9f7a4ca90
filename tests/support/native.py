# SPDX-License-Identifier: Apache-2.0
"""What CMake and binutils do and say of libraries."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from hypgen.runtime.builder import tools


def build_with_cmake(source: Path, build: Path, *settings: str) -> Path:
    """Build a project by plain CMake, as users have it; return the folder that it was built in."""
    cmake = str(tools.find_cmake().path)
    environment = {name: value for name, value in os.environ.items() if name != "CXXFLAGS"}  # of the tests
    for command in (
        [cmake, "-S", str(source), "-B", str(build), *settings],
        [cmake, "--build", str(build), "--parallel", "2"],
    ):
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
    return build


def c_names_of(program: Path) -> set[str]:
    """Return the global names with C linkage that an archive, a library or a program defines itself."""
    if shutil.which("nm") is None:
        pytest.skip("needs nm")
    command = ["nm", "-g", "--defined-only", "--format=posix", str(program)]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    names = {line.split()[0] for line in listed.splitlines() if len(line.split()) > 1}
    # C++ names begin with _Z, what compilers and the C library add with other underscores or DW.ref.
    added = {"main", "data_start"}
    return {name for name in names if not name.startswith(("_", "DW.ref."))} - added


def exported_by(library: Path) -> tuple[set[str], str]:
    """Return the names that a shared library exports, and what it needs, as readelf shows it."""
    if shutil.which("nm") is None or shutil.which("readelf") is None:
        pytest.skip("needs nm and readelf")
    names = ["nm", "-D", "--defined-only", str(library)]
    listed = subprocess.run(names, capture_output=True, text=True, check=True).stdout
    needs = ["readelf", "-d", str(library)]
    dynamic = subprocess.run(needs, capture_output=True, text=True, check=True).stdout
    return {line.split()[-1] for line in listed.splitlines()}, dynamic
