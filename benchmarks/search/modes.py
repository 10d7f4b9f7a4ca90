# SPDX-License-Identifier: Apache-2.0
"""Compares the modes of solvers on this machine: how fast each one's tree grows.

python3 benchmarks/search/modes.py SOLVER [SOLVER ...] [--modes despot,parallel] [--threads N] [--time 1]

SOLVER is a program that ``hypgen compile`` made. Each mode plans the first steps of one episode; the first
decision, which meets fresh pages, is left out. Needs Python and nothing of hypgen's.
"""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path
from statistics import fmean
from typing import Any

COLUMNS = (
    "mode", "threads", "in flight", "expansions/s", "nodes/s made", "trials/s", "depth", "scenarios a leaf",
    "simulations/s", "leaves a batch", "GPU busy", "waiting", "descent", "backup",
    "collisions", "searches end with",
)  # fmt: skip


def plan(solver: Path, mode: str, asked: argparse.Namespace) -> list[dict[str, Any]]:
    """Return the JSON lines of one run; none where the mode cannot be had, which is printed."""
    command = [str(solver), "--mode", mode, "--quiet", "--json", "-", "--runs", "1"]
    command += ["--steps", str(asked.steps), "--time", str(asked.time), "--scenarios", str(asked.scenarios)]
    command += ["--seed", str(asked.seed), "--memory", str(asked.memory)]
    if mode in ("parallel", "hyp") and asked.threads:
        command += ["--threads", str(asked.threads)]
    if mode in ("gpu", "hyp"):
        command.append("--require-gpu")
        command += ["--in-flight", str(asked.in_flight)] if asked.in_flight else []
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"{solver.name}, {mode}: {done.stderr.strip()[-300:]}")
        return []
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def row(mode: str, lines: list[dict[str, Any]]) -> list[str]:
    """Return a line of the table."""
    run = next(line for line in lines if line["type"] == "run")
    summary = next(line for line in lines if line["type"] == "summary")
    steps = [line for line in lines if line["type"] == "step"]
    steps = [step for step in steps if step["search_seconds"] > 0][1:] or steps

    def rate(name: str) -> str:
        return f"{fmean(step[name] / step['search_seconds'] for step in steps):,.0f}"

    expansions = sum(step["expansions"] for step in steps)
    searched = sum(line["search_seconds"] for line in lines if line["type"] == "step")
    has_gpu = summary["batches"] > 0

    def share(name: str) -> str:
        return f"{fmean(step[name] / step['search_seconds'] for step in steps):.1%}"

    return [
        mode, str(run["threads"]), str(run["in_flight"]),
        rate("expansions"), rate("children"), rate("trials"), str(max(step["max_depth"] for step in steps)),
        f"{sum(step['leaf_scenarios'] for step in steps) / max(1, expansions):.1f}",
        f"{fmean(step['simulations'] / step['search_seconds'] for step in steps):.2g}",
        f"{summary['leaves_a_batch']:.1f}" if has_gpu else "",
        f"{summary['seconds_kernels'] / searched:.0%}" if has_gpu else "",
        share("waiting_seconds"), share("descent_seconds"), share("backup_seconds"),
        f"{sum(step['collisions'] for step in steps) / max(1, expansions):.3f}",
        ", ".join(sorted({step["status"] for step in steps})),
    ]  # fmt: skip


def main() -> None:
    """Run all modes of all solvers; print a table for each solver."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solvers", nargs="+", type=Path)
    parser.add_argument("--modes", default="rollout,despot,parallel,gpu,hyp", help="separated by commas")
    parser.add_argument("--threads", type=int, help="of parallel and hyp (all cores)")
    parser.add_argument("--in-flight", type=int, help="of gpu and hyp (the solver's default)")
    parser.add_argument("--time", type=float, default=1.0, help="seconds a decision (1)")
    parser.add_argument("--steps", type=int, default=3, help="decisions (3)")
    parser.add_argument("--scenarios", type=int, default=500, help="of a search (500)")
    parser.add_argument("--memory", type=int, default=16000, help="MiB of a search (16000)")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    for solver in asked.solvers:
        print(f"\n{solver.name}, K {asked.scenarios}, {asked.time:g} s a decision\n")
        print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|", flush=True)
        for mode in asked.modes.split(","):
            lines = plan(solver, mode, asked)
            if lines:
                print("| " + " | ".join(row(mode, lines)) + " |", flush=True)


if __name__ == "__main__":
    main()
