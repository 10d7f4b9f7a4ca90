# SPDX-License-Identifier: Apache-2.0
"""Plays many episodes of small models with the online planner and compares the mean with proven intervals.

python3 benchmarks/exact/online.py INTERVALS.json SOLVER [SOLVER ...] [--runs 1000] [--trials 200] [--jobs 2]

SOLVER is a program that ``hypgen compile`` made; INTERVALS.json has, by the solver's name, [lower, upper] as
``hypgen solve --json`` gives them. An episode without an end is cut off where what is left cannot change the
return by more than a thousandth. Needs Python and nothing of hypgen's.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

PIECE = 50  # episodes of a process
REST = 1e-3  # of the discount's sum, that is cut off
COLUMNS = (
    "model",
    "proven",
    "episodes",
    "mean return",
    "difference",
    "trials a step",
    "core seconds",
    "verdict",
)


def lines_of(command: list[str]) -> list[dict[str, Any]]:
    """Return the JSON lines that a solver prints."""
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


@dataclass
class Played:
    """What a solver's episodes came to."""

    returns: list[float] = field(default_factory=list)
    trials: list[float] = field(default_factory=list)
    seconds: float = 0.0


def steps_of(solver: Path) -> int:
    """Return after how many steps what is left of the discount's sum is negligible."""
    run = lines_of([str(solver), "--runs", "1", "--steps", "1", "--quiet", "--json", "-"])[0]
    discount = run["discount"]
    return 1000 if discount >= 1 else max(1, math.ceil(math.log(REST) / math.log(max(discount, 1e-9))))


def play(solver: Path, steps: int, first: int, asked: argparse.Namespace) -> Played:
    """Play some of a solver's episodes."""
    start = time.monotonic()
    runs = min(PIECE, asked.runs - first)
    command = [str(solver), "--mode", "despot", "--first-run", str(first), "--runs", str(runs)]
    command += ["--steps", str(steps), "--trials", str(asked.trials), "--time", str(asked.time)]
    command += ["--seed", str(asked.seed), "--scenarios", str(asked.scenarios), "--quiet", "--json", "-"]
    lines = lines_of(command)
    returns = [line["discounted_return"] for line in lines if line["type"] == "episode"]
    return Played(returns, [lines[-1]["trials_a_step"]], time.monotonic() - start)


def row(name: str, interval: list[float], played: Played) -> list[str]:
    """Return a model's line of the table."""
    lower, upper = interval
    mean = statistics.fmean(played.returns)
    half = 1.96 * statistics.stdev(played.returns) / math.sqrt(len(played.returns))
    off = mean - lower if mean < lower else mean - upper if mean > upper else 0.0
    verdict = "within its interval" if abs(off) <= half else "below" if off < 0 else "above"
    return [
        name, f"{lower:.5g} .. {upper:.5g}", str(len(played.returns)), f"{mean:.4g} +- {half:.2g}",
        f"{off:+.3g}", f"{statistics.fmean(played.trials):.0f}", f"{played.seconds:.0f}", verdict,
    ]  # fmt: skip


def main() -> None:
    """Play all and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("intervals", type=Path)
    parser.add_argument("solvers", nargs="+", type=Path)
    parser.add_argument("--runs", type=int, default=1000, help="episodes (1000)")
    parser.add_argument("--trials", type=int, default=200, help="of a decision, at most (200)")
    parser.add_argument("--time", type=float, default=0.02, help="seconds a decision, at most (0.02)")
    parser.add_argument("--scenarios", type=int, default=500, help="of a decision (500)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time (1)")
    asked = parser.parse_args()
    intervals = json.loads(asked.intervals.read_text())
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|", flush=True)
    with ThreadPoolExecutor(asked.jobs) as pool:
        pieces = {
            solver: [pool.submit(play, solver, steps, first, asked) for first in range(0, asked.runs, PIECE)]
            for solver in asked.solvers
            for steps in [steps_of(solver)]
        }
        for solver, playing in pieces.items():
            whole = Played()
            for piece in (one.result() for one in playing):
                whole.returns += piece.returns
                whole.trials += piece.trials
                whole.seconds += piece.seconds
            print("| " + " | ".join(row(solver.name, intervals[solver.name], whole)) + " |", flush=True)


if __name__ == "__main__":
    main()
