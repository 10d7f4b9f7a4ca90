# SPDX-License-Identifier: Apache-2.0
"""Asks how right the beliefs are about what stands still near the edge of a lane.

python3 benchmarks/beliefs/standing.py [--episodes 1000] [--steps 25] [--seed 7]

Needs an installed hypgen. Prints the first two tables of docs/results/beliefs.md: a person whom nothing
else depends on, and a beacon that is seen together with other hidden state.
"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from hypgen.codegen.generate import generate
from hypgen.dsl import load
from hypgen.runtime.builder.solver import build_solver

HERE = Path(__file__).parent
MODELS = HERE.parent / "models"
MAIN, LIBRARY = "src/main.cpp", "src/library.cpp"
HEADERS = ("cmath", "cstdio", "cstdlib", "ctime")


def main() -> None:
    """Print a line for each number of people and of particles, and one for the beacon."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--steps", type=int, default=25)
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    print(
        "| people | particles | error | its own deviation | off by over 2 | over 3"
        " | sure of a free lane, wrongly | steps unexplained | update [ms of a core] |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for people, particles in ((2, 5000), (8, 5000), (2, 1000)):
        program = build("standing_people", "standing.cpp", f"people={people}")
        print(f"| {people} | {particles:,}", run(program, particles, options), flush=True)
    print(
        "\n| particles | from Bayes' mean [deviations] | its own deviation | Bayes' | off by over 2 | over 3"
        " | sure of a free lane, wrongly | steps unexplained | update [ms of a core] |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    print("| 5,000", run(build("beacon", "beacon.cpp"), 5000, options), flush=True)


def run(program: Path, particles: int, options: argparse.Namespace) -> str:
    """Return the program's line."""
    command = [program, options.episodes, particles, options.steps, options.seed]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout.strip()


def build(model: str, program: str, *settings: str) -> Path:
    """Return the program for a model."""
    files = generate(load.load(MODELS / f"{model}.pomdp", settings=settings).model)
    includes = "".join(f"#include <{name}>\n" for name in HEADERS)
    files[MAIN] = includes + files.pop(LIBRARY) + (HERE / program).read_text(encoding="utf-8")
    return build_solver(files, " ".join((model, *settings)), lambda step: None)


if __name__ == "__main__":
    main()
