# SPDX-License-Identifier: Apache-2.0
"""Compiled solvers act legally, whatever little they have: time, memory, scenarios, cores, choices."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
# Nothing to choose and nothing to see: there is one leaf at a time.
ONE_WAY = """\
model OneWay
enum Act  { on }
enum Sign { nothing }
discount 0.95
action act: Act
element track {
  hidden good: bool
  init good ~ bernoulli(0.5)
  good' = track.good
}
observe seen: Sign = nothing
reward step = if track.good then 1 else 0
policy default = on
bound upper = 1 / (1 - gamma)
"""
ACTIONS = {"one_way": {"on"}, "tiger": {"listen", "open_left", "open_right"}}
SEARCHES = {"ok", "deadline", "memory_full", "trial_limit", "converged"}
SETTINGS = {
    "more threads than cores": ("--threads", "64", "--time", "0.01"),
    "a deadline of 1 ms": ("--threads", "4", "--time", "0.001"),
    "1 MB": ("--threads", "4", "--memory", "1", "--trials", "100000", "--time", "1"),
    "one scenario": ("--threads", "4", "--scenarios", "1", "--trials", "500"),
    "one trial": ("--threads", "16", "--trials", "1"),
    "one particle": ("--threads", "2", "--particles", "1", "--trials", "20"),
}


@pytest.fixture(scope="module", params=list(ACTIONS))
def solver(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    model = ROOT / "examples" / f"{request.param}.pomdp"
    if not model.is_file():
        model = tmp_path_factory.mktemp("models") / model.name
        model.write_text(ONE_WAY)
    return build_solver(generate(load(model).model), f"little/{model.stem}", lambda step: None)


def run(solver: Path, *options: str) -> tuple[int, list[dict[str, Any]]]:
    command = [solver, "--mode", "parallel", "--quiet", "--json", "-", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.parametrize("setting", SETTINGS)
def test_actions_are_legal(solver: Path, setting: str) -> None:
    code, lines = run(solver, "--runs", "1", "--steps", "4", *SETTINGS[setting])
    assert code == 0
    steps = [line for line in lines if line["type"] == "step"]
    assert len(steps) == 4
    for step in steps:
        assert step["action_name"] in ACTIONS[solver.name]
        assert step["status"] in SEARCHES
        if step["lower"] is not None:  # else threads were late, and nothing was searched
            assert step["lower"] <= step["upper"]


@pytest.mark.parametrize("threads", ["0", "1025", "-1", "many"])
def test_impossible_numbers_of_threads_are_refused(solver: Path, threads: str) -> None:
    assert run(solver, "--threads", threads) == (2, [])


def test_the_benchmark_of_deadlines_reads_what_a_solver_writes(solver: Path) -> None:
    script = ROOT / "benchmarks" / "search" / "deadlines.py"
    command = ["python3", script, solver, "--time", "0.002", "--plans", "30", "--modes", "parallel"]
    done = subprocess.run([*command, "--threads", "2"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    head, row = [line.split(" | ") for line in done.stdout.splitlines() if " | " in line]
    assert head[:5] == ["| model", "mode", "threads", "plans", "p50"]
    assert row[1:4] == ["parallel", "2", "30"] and all(float(value) < 1000 for value in row[4:8])
