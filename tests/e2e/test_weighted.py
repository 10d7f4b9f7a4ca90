# SPDX-License-Identifier: Apache-2.0
"""Trees whose groups share scenarios: what a solver plans with them, and what it refuses."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from support.paths import EXAMPLES

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
WEIGHTED = ("--observations", "weighted")


@pytest.fixture(scope="module", params=["tiger", "laser_tag"])
def solver(request: pytest.FixtureRequest) -> Path:
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    model = load(EXAMPLES / f"{request.param}.pomdp").model
    return build_solver(generate(model), f"signature/{request.param}", lambda step: None)


def play(solver: Path, *options: str) -> tuple[str, list[dict[str, Any]]]:
    """Return what a solver prints, and the steps of its JSON lines."""
    command = [str(solver), "--mode", "despot", "--seed", "3", "--runs", "1", "--steps", "4", "--quiet"]
    done = subprocess.run([*command, *options, "--json", "-"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    return done.stdout, [line for line in lines if line["type"] == "step"]


def decided(steps: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
    return [(s["action"], s["lower"], s["upper"], s["expansions"], s["nodes"]) for s in steps]


def test_the_same_trials_give_the_same_trees(solver: Path) -> None:
    options = ("--trials", "60", "--scenarios", "200")
    once, again = (play(solver, *options, *WEIGHTED)[1] for _ in range(2))
    assert decided(once) == decided(again)
    assert all(s["expansions"] > 1 and s["lower"] <= s["upper"] for s in once)
    assert decided(once) != decided(play(solver, *options)[1])


@pytest.mark.parametrize("solver", ["tiger"], indirect=True)
def test_where_little_is_seen_bounds_are_about_those_of_an_exact_tree(solver: Path) -> None:
    options = ("--trials", "300", "--scenarios", "500", "--pruning", "0")
    exact, weighted = (play(solver, *options, *more)[1][0] for more in ((), WEIGHTED))
    gap = exact["upper"] - exact["lower"]
    assert weighted["upper"] == pytest.approx(exact["upper"], abs=1.0 + gap)
    assert weighted["lower"] == pytest.approx(exact["lower"], abs=1.0 + gap)


def test_several_threads_share_a_tree_within_a_time_limit(solver: Path) -> None:
    options = ("--mode", "parallel", "--threads", "2", "--time", "0.05", *WEIGHTED)
    steps = play(solver, *options)[1]
    assert len(steps) > 0 and all(s["looked"] in ("tree", "one_step") for s in steps)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--mode", "pomcp"], "--observations: mode pomcp follows single observations"),
        (["--observations", "some"], "exact or weighted"),
    ],
)
def test_what_cannot_be_weighted_is_refused(solver: Path, options: list[str], says: str) -> None:
    done = subprocess.run([str(solver), *WEIGHTED, *options], capture_output=True, text=True)
    assert done.returncode == 2 and says in done.stderr
