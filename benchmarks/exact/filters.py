# SPDX-License-Identifier: Apache-2.0
"""Compares our filters with the exact one: distance by particles, calibration, the factored filter's error.

python3 benchmarks/exact/filters.py [--episodes 200] [--steps 20] [--seed 1] [--ranks 2000]
python3 benchmarks/exact/filters.py --models rs_4_4,rs_5_7 --beliefs factored --steps 50

Needs an installed hypgen. Prints the tables of docs/results/exact.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from filter_program import build, chi_square, compare, slope

EXAMPLES = Path(__file__).parents[2] / "examples"
MODELS = {
    "tiger": ("tiger.pomdp", ()),
    "rs_4_4": (
        "rock_sample.pomdp",
        ("n=4", "k=4", "start_row=2", "rock_x=[3,2,1,1]", "rock_y=[1,1,3,0]"),
    ),
    "rs_5_7": (
        "rock_sample.pomdp",
        ("n=5", "k=7", "start_row=2", "rock_x=[1,2,1,2,4,0,3]", "rock_y=[0,1,2,2,2,3,4]"),
    ),
    "tag": ("tag.pomdp", ()),
}
PARTICLES = (100, 1000, 10_000, 100_000)
BELIEFS = ("exact", "limit", "particle", "factored")

Programs = dict[str, Path]


def main() -> None:
    """Print a table of distances and one of calibration."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--episodes", type=int, default=200, help="episodes for a distance")
    parser.add_argument("--steps", type=int, default=20, help="most steps of an episode")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ranks", type=int, default=2000, help="episodes for a calibration")
    parser.add_argument("--models", default=",".join(MODELS), help="some of them")
    parser.add_argument("--beliefs", default=",".join(BELIEFS), help="some of them")
    options = parser.parse_args()
    beliefs = options.beliefs.split(",")
    settings = {"steps": options.steps, "seed": options.seed}
    programs = {
        name: build(EXAMPLES / MODELS[name][0], MODELS[name][1]) for name in options.models.split(",")
    }
    if "particle" in beliefs:
        distances(programs, settings | {"episodes": options.episodes})
    calibration(programs, beliefs, settings | {"episodes": options.ranks})


def distances(programs: Programs, settings: dict[str, Any]) -> None:
    """Print how far particle filters are from the exact belief, by their particles."""
    print("| model | steps |", *(f" N {n:,} |" for n in PARTICLES), " slope | depleted |", sep="")
    print("|---|---|", "---|" * (len(PARTICLES) + 2), sep="")
    for name, program in programs.items():
        found = [compare(program, "particle", n, **settings) for n in PARTICLES]
        means = [result["mean"] for result in found]
        cells = [f"{found[-1]['updates']:,}", *(f"{mean:.5f}" for mean in means)]
        cells.append(f"{slope(list(zip(PARTICLES, means, strict=True))):.3f}")
        print("|", " | ".join([name, *cells, ", ".join(str(r["failures"]) for r in found)]), "|", flush=True)
    print()


def calibration(programs: Programs, beliefs: Sequence[str], settings: dict[str, Any]) -> None:
    """Print the chi-square of the true state's rank, and how far each belief is from the exact one."""
    print("| model | belief | steps | episodes | chi-square (9) | mean distance | largest distance |")
    print("|---|---|---|---|---|---|---|")
    for name, program in programs.items():
        for kind in beliefs:
            if kind == "factored" and not name.startswith("rs"):
                continue
            result = compare(program, kind, 1000, **settings)
            counts = f"{result['updates']:,} | {sum(result['ranks']):,} | {chi_square(result['ranks']):.1f}"
            row = f"{counts} | {result['mean']:.2g} | {result['largest']:.2g}"
            print(f"| {name} | {kind} | {row} |", flush=True)


if __name__ == "__main__":
    main()
