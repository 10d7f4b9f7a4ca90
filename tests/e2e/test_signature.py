# SPDX-License-Identifier: Apache-2.0
"""The search builds the same tree, bit for bit, whatever the optimisation level.

Other tests compile solvers with -O1 (``tests/conftest.py``), here one is as users have it.
"""

from __future__ import annotations

import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from support.pinned import PINS, signatures

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = [pytest.mark.cxx, pytest.mark.unoptimised]
ROOT = Path(__file__).parent.parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.pomdp"))
RUNTIME = ROOT / "runtime"
SEARCH = ("--runs", "2", "--steps", "3", "--trials", "12", "--scenarios", "60")
# Unoptimised code takes minutes for a search like that in models with many actions or elements.
SMALL_SEARCH = ("--runs", "1", "--steps", "2", "--trials", "3", "--scenarios", "6", "--depth", "15")
LARGE = {"crowd_driving", "laser_tag", "navigation", "pocman", "two_robot_rock_sample"}


@pytest.fixture(scope="module")
def unoptimised(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[str], list[Path]]:
    """The command that compiles without optimisation, and the runtime's objects compiled by it."""
    try:
        tools = find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    folder = tmp_path_factory.mktemp("unoptimised")
    flags = ["-std=c++17", "-O0", *host_flags(), f"-I{RUNTIME / 'include'}", f"-I{tools.json_include}"]
    command = [str(tools.compiler.path), *flags]

    def compile_source(source: Path) -> Path:
        target = folder / f"{source.parent.name}_{source.stem}.o"
        subprocess.run([*command, "-c", str(source), "-o", str(target)], check=True)
        return target

    sources = sorted(p for p in (RUNTIME / "src").rglob("*.cpp") if p.parent.name != "exact")
    with ThreadPoolExecutor(2) as pool:
        return command, list(pool.map(compile_source, sources))


@pytest.mark.parametrize(
    "example",
    [pytest.param(p, id=p.stem, marks=[pytest.mark.slow] if p.stem in LARGE else []) for p in EXAMPLES],
)
def test_same_tree_at_O0_and_O3(
    example: Path,
    unoptimised: tuple[list[str], list[Path]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("CXXFLAGS")
    command, objects = unoptimised
    search = SMALL_SEARCH if example.stem in LARGE else SEARCH
    files = generate(load(example).model)
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    slow = tmp_path / "solver"
    units = [str(tmp_path / "src" / name) for name in ("main.cpp", "library.cpp")]
    sources = [f"-I{tmp_path / 'include'}", *units, *map(str, objects)]
    subprocess.run([*command, *sources, "-o", str(slow)], check=True)
    fast = build_solver(files, f"signature/{example.stem}", lambda step: None)
    assert signatures(fast, example.stem) == PINS[example.stem]
    found = [
        subprocess.run(
            [solver, "--mode", "despot", *search, "--seed", "5", "--signature", "--quiet"],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for solver in (slow, fast)
    ]
    assert found[0].strip() and found[0] == found[1]
