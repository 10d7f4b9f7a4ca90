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
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

REST = 1e-3  # of the discount's sum, that is cut off
COLUMNS = ("model", "proven", "episodes", "mean return", "difference", "trials a step", "seconds", "verdict")


def lines_of(command: list[str]) -> list[dict[str, Any]]:
    """Return the JSON lines that a solver prints."""
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def play(solver: Path, asked: argparse.Namespace) -> tuple[dict[str, Any], float]:
    """Return the summary of a solver's episodes and how long they took."""
    start = time.monotonic()
    discount = lines_of([str(solver), "--runs", "1", "--steps", "1", "--quiet", "--json", "-"])[0]["discount"]
    steps = 1000 if discount >= 1 else max(1, math.ceil(math.log(REST) / math.log(max(discount, 1e-9))))
    command = [str(solver), "--mode", "despot", "--runs", str(asked.runs), "--steps", str(steps)]
    command += ["--trials", str(asked.trials), "--time", str(asked.time), "--seed", str(asked.seed)]
    command += ["--scenarios", str(asked.scenarios), "--quiet", "--json", "-"]
    return lines_of(command)[-1], time.monotonic() - start


def row(name: str, interval: list[float], summary: dict[str, Any], seconds: float) -> list[str]:
    """Return a model's line of the table."""
    lower, upper = interval
    mean, half = summary["discounted_return"], summary["interval95"]
    off = mean - lower if mean < lower else mean - upper if mean > upper else 0.0
    verdict = "within its interval" if abs(off) <= half else "below" if off < 0 else "above"
    return [
        name, f"{lower:.5g} .. {upper:.5g}", str(summary["episodes"]), f"{mean:.4g} +- {half:.2g}",
        f"{off:+.3g}", f"{summary['trials_a_step']:.0f}", f"{seconds:.0f}", verdict,
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
    parser.add_argument("--jobs", type=int, default=1, help="solvers at a time (1)")
    asked = parser.parse_args()
    intervals = json.loads(asked.intervals.read_text())
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|", flush=True)
    with ThreadPoolExecutor(asked.jobs) as pool:
        for solver, (summary, seconds) in zip(
            asked.solvers, pool.map(lambda one: play(one, asked), asked.solvers), strict=True
        ):
            print(
                "| " + " | ".join(row(solver.name, intervals[solver.name], summary, seconds)) + " |",
                flush=True,
            )


if __name__ == "__main__":
    main()
