# SPDX-License-Identifier: Apache-2.0
"""Asks how right the belief about a person is who stands near the edge of a lane.

python3 benchmarks/beliefs/standing.py [--episodes 1000] [--steps 25] [--seed 7]

Needs an installed hypgen. Prints the first table of docs/results/beliefs.md.
"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from hypgen.codegen.generate import generate
from hypgen.dsl import load
from hypgen.runtime.builder.solver import build_solver

HERE = Path(__file__).parent
MODEL = HERE.parent / "models" / "standing_people.pomdp"
MAIN = "src/main.cpp"
HEADERS = ("cmath", "cstdio", "cstdlib", "ctime")


def main() -> None:
    """Print a line for each number of people and of particles."""
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
        command = [build(people), options.episodes, particles, options.steps, options.seed]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True)
        print(f"| {people} | {particles:,}", done.stdout.strip(), flush=True)


def build(people: int) -> Path:
    """Return the program for so many people."""
    files = generate(load.load(MODEL, settings=(f"people={people}",)).model)
    beginning, _, _ = files[MAIN].partition("int main(")
    includes = "".join(f"#include <{name}>\n" for name in HEADERS)
    files[MAIN] = includes + beginning + (HERE / "standing.cpp").read_text(encoding="utf-8")
    return build_solver(files, f"standing {people}", lambda step: None)


if __name__ == "__main__":
    main()
