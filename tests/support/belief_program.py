# SPDX-License-Identifier: Apache-2.0
"""Compiles a generated model with one of the runtime's beliefs, and returns what that holds to be true."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import find_tools
from support.paths import ROOT

MAIN = Path(__file__).parent / "belief_main.cpp"
INCLUDE = ROOT / "runtime" / "include"


def beliefs(
    header: str, model: str, belief: str, folder: Path, particles: int, steps: int
) -> npt.NDArray[np.float64]:
    """Return a row for each step: how it ended, the action, the key, and the probabilities of all values.

    A variable has eight columns, for the values 0 to 7.
    """
    try:
        compiler = str(find_tools().compiler.path)
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    folder.mkdir()
    (folder / "model.hpp").write_text(header)
    program = str(folder / "belief")
    names = [f'-DHEADER="{folder / "model.hpp"}"', f"-DMODEL={model}", f"-DBELIEF={belief}", f"-I{INCLUDE}"]
    flags = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror", *host_flags()]
    subprocess.run([compiler, *flags, *names, str(MAIN), "-o", program], check=True)
    run = [program, str(particles), str(steps)]
    rows = subprocess.run(run, check=True, capture_output=True, text=True).stdout.splitlines()
    return np.array([[float(x) for x in row.split()] for row in rows])
