# SPDX-License-Identifier: Apache-2.0
"""Measures how far what a policy knows of a float is from the posterior on a fine grid.

    PYTHONPATH=tests python benchmarks/beliefs/floats.py                 # 40 episodes of each model
    PYTHONPATH=tests python benchmarks/beliefs/floats.py --episodes 5    # a quick look

The models are in benchmarks/beliefs/floats; episodes are those of their default policies, at most 20 steps.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from support.grid_filter import GridFilter, distances

from hypgen.dsl.load import load

FOLDER = Path(__file__).resolve().parent / "floats"
CELLS = 400
FLOATS = {
    "cart": ("cart", -8.0, 8.0),
    "coin": ("coin", 0.0, 1.0),
    "sonar": ("wreck", 0.0, 20.0),
    "tank": ("tank", -4.0, 16.0),
    "rangefinder": ("beacon", -15.0, 35.0),
}


def main() -> None:
    """Print a row for each model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--steps", type=int, default=20)
    given = parser.parse_args()
    print("| model | steps | mean off: average | 95 % | most | deviations' ratio: 5 % | median | 95 % |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name, (element, low, high) in FLOATS.items():
        model = load(FOLDER / f"{name}.pomdp").model
        grid = GridFilter(model, element, low, high, CELLS)
        apart, ratio = distances(model, grid, given.episodes, given.steps, 1).T
        off = np.abs(apart)
        figures = [off.mean(), np.quantile(off, 0.95), off.max(), *np.quantile(ratio, [0.05, 0.5, 0.95])]
        print(f"| {name} | {len(off)} | {' | '.join(f'{x:.3f}' for x in figures)} |", flush=True)


if __name__ == "__main__":
    main()
