# SPDX-License-Identifier: Apache-2.0
"""A search sets lambda itself where scenarios part: where each soon sees something that no other sees."""

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
TIGER = Path(__file__).parent.parent.parent / "examples" / "tiger.pomdp"
# A walk to place 0 with a sensor of 200 values.
WALK = """\
model Walk
type Place = -60 .. 60
type Seen = 0 .. 199
enum Act { left, stop, right }
discount 0.95
action act: Act
element agent {
  hidden s: Place
  init s ~ uniform(k in -30 .. 30)
  s' = clamp(s + (if act == left then -5 else if act == right then 5 else 0))
  observe seen: Seen ~ binned(normal(s', 1 + abs(s' - 10)), -100.0, 100.0)
}
reward r = if act != stop then -1 else if abs(agent.s) < 3 then 100 else -100
terminal when act == stop
policy default = if belief(agent.s) < 0 then right else left
bound upper = 100
"""
# Many actions, and nothing to see: a comparison takes few scenarios at a time.
BOXES = """\
model Boxes
type Box = 0 .. 299
enum Sign { nothing }
discount 0.95
action pick: Box
element coin {
  hidden at: Box
  init at ~ uniform(Box)
  at' = coin.at
}
observe seen: Sign = nothing
reward hit = if pick == coin.at then 100 else 0
policy default = 0
bound upper = 100 / (1 - gamma)
"""


def built(folder: Path, text: str) -> Path:
    """Return the solver of a model."""
    path = folder / "model.pomdp"
    path.write_text(text)
    return build_solver(generate(load(path).model), "pruning", lambda step: None)


def lambdas(solver: Path, *options: str) -> list[float]:
    """Return lambda of the trees in the first steps of episodes."""
    command = [str(solver), "--mode", "despot", "--runs", "4", "--steps", "1", "--quiet", "--json", "-"]
    trees: list[dict[str, Any]] = []
    for _ in range(20):  # other processes may hold the processor until a plan's time is over
        done = subprocess.run([*command, *options], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        steps = [json.loads(line) for line in done.stdout.splitlines() if '"type":"step"' in line]
        trees = [step for step in steps if step["looked"] == "tree"]
        if trees:
            break
    assert trees
    assert all(step["scenarios"] > 0 for step in trees)
    return [step["pruning"] for step in trees]


def test_lambda_follows_the_model(tmp_path: Path) -> None:
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    walk, boxes = (built(tmp_path, text) for text in (WALK, BOXES))
    # A scenario's gain is up to 200, of which one of 500 scenarios has its share.
    assert all(0.01 < one <= 0.4 for one in lambdas(walk, "--time", "0.3"))
    assert set(lambdas(walk, "--time", "0.3", "--pruning", "0")) == {0.0}
    assert set(lambdas(walk, "--time", "0.3", "--pruning", "0.25")) == {0.25}
    assert set(lambdas(walk, "--trials", "20")) == {0.0}
    assert set(lambdas(boxes, "--time", "0.05", "--depth", "5")) == {0.0}
    tiger = build_solver(generate(load(TIGER).model), "pruning/tiger", lambda step: None)
    assert set(lambdas(tiger, "--time", "0.05")) == {0.0}
    assert set(lambdas(tiger, "--time", "0.05", "--scenarios", "30")) == {0.0}
