# SPDX-License-Identifier: Apache-2.0
"""One thread builds the same tree, bit for bit, as when the table was made.

The table (``pinned_signatures.json``) was last made when leaves began to roll out few actions, that of
navigation when its particles began to draw all first words by the model's own names, and that of
crowd_driving, light_dark and pocman when moves of particles got names for up to 128 words. A change that
does not mean to change arithmetic, the order of trials or what an example says must leave it as it is.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.pomdp"))
PINS = json.loads((Path(__file__).parent / "pinned_signatures.json").read_text())
SEARCH = ("--runs", "2", "--steps", "3", "--trials", "60", "--scenarios", "50", "--depth", "20")
# 529 actions, each with a rollout for each scenario of a leaf.
SMALL_SEARCH = ("--runs", "1", "--steps", "2", "--trials", "8", "--scenarios", "10", "--depth", "12")
LARGE = {"two_robot_rock_sample"}
VARIANTS = {
    "F 1": ("--in-flight", "1"),
    "F 16": ("--in-flight", "16"),
    "F 16, lambda 0.05": ("--in-flight", "16", "--pruning", "0.05"),
}
# A few: many actions, observations or scenarios a leaf, and none of these.
EXPLORING = {"laser_tag", "navigation", "rock_sample", "tiger"}
EXPLORING_VARIANTS = {
    "F 1, c_a 0.3": ("--in-flight", "1", "--exploration", "0.3"),
    "F 16, c_a 0.3": ("--in-flight", "16", "--exploration", "0.3"),
}


def test_every_example_is_pinned() -> None:
    assert list(PINS) == [path.stem for path in EXAMPLES]


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_signatures_are_those_of_the_table(example: Path) -> None:
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    solver = build_solver(generate(load(example).model), f"signature/{example.stem}", lambda step: None)
    search = SMALL_SEARCH if example.stem in LARGE else SEARCH
    variants = VARIANTS | (EXPLORING_VARIANTS if example.stem in EXPLORING else {})
    found = {name: signature(solver, (*search, *options)) for name, options in variants.items()}
    assert found == PINS[example.stem]


def signature(solver: Path, options: tuple[str, ...]) -> str:
    """Return the hash over all trees of a run."""
    command = [str(solver), "--mode", "despot", *options, "--seed", "5", "--signature", "--quiet"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout.removeprefix("signature ").strip()
