# SPDX-License-Identifier: Apache-2.0
"""Functions in lanes against the same functions of scalars, bit for bit, for each kind of processor."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.runtime.builder.compile_flags import host_flags, lane_flags
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import find_compiler, widest_lanes

pytestmark = pytest.mark.cxx
KINDS = [*lane_flags()]  # the widest first


@pytest.mark.parametrize("kind", KINDS)
def test_functions_have_the_same_bits(kind: str, tmp_path: Path) -> None:
    try:
        compiler = find_compiler()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    widest = widest_lanes(compiler)
    if not widest or KINDS.index(kind) < KINDS.index(widest):
        pytest.skip(f"this machine has no {kind}")
    source, program = Path(__file__).parent / "lanes_main.cpp", tmp_path / "lanes"
    flags = ["-std=c++17", "-O1", "-w", *host_flags(), *lane_flags()[kind]]
    command = [compiler.path, *flags, f"-I{ROOT / 'runtime' / 'include'}", source, "-o", program]
    subprocess.run(command, check=True)
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.stdout == f"{16 if kind == 'avx512' else 8} lanes, 0 differing\n"
