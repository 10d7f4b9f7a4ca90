# SPDX-License-Identifier: Apache-2.0
"""Measure one core's search speed: docs/results/throughput.md has the table.

    python benchmarks/throughput.py [--runs 5]

The setting of the figures that it stands beside: K = 500, 1 s a step, one search thread. Each run is one
process on one episode; the table has the median run and the range. Use an otherwise idle machine.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from machine import ROOT, machine

# Public DESPOT (AdaCompNUS), K 500, 1 CPU-second a step, one core of a 2-core 2.x GHz Xeon: expansions/s.
PUBLIC = {"tiger": 70_000, "rock_sample": 4_300, "rs_11_11": 2_500, "tag": 2_500}
FIGURES = ("expansions_a_second", "nodes_a_second", "simulations_a_second", "scenarios_a_leaf")


def command(model: str, seed: int, seconds: float, steps: int) -> list[str]:
    """Return the command of one run."""
    return [
        "hypgen", "run", f"examples/{model}.pomdp", "--mode", "despot", "--time", str(seconds),
        "--scenarios", "500", "--runs", "1", "--steps", str(steps), "--seed", str(seed),
    ]  # fmt: skip


def measure(model: str, seed: int, seconds: float, steps: int) -> dict[str, float]:
    """Run one episode and return the summary's figures."""
    with tempfile.TemporaryDirectory() as folder:
        lines = Path(folder) / "lines.jsonl"
        arguments = [*command(model, seed, seconds, steps), "--quiet", "--json", str(lines)]
        arguments[0] = str(Path(sys.executable).with_name("hypgen"))
        subprocess.run(arguments, cwd=ROOT, check=True)
        summary = json.loads(lines.read_text().splitlines()[-1])
    return {figure: float(summary[figure]) for figure in FIGURES}


def row(model: str, runs: list[dict[str, float]]) -> str:
    """Return one line of the table."""
    rates = sorted(r["expansions_a_second"] for r in runs)
    median = {figure: statistics.median(r[figure] for r in runs) for figure in FIGURES}
    return (
        f"| {model} | {median['expansions_a_second']:,.0f} ({rates[0]:,.0f} to {rates[-1]:,.0f}) "
        f"| {PUBLIC[model]:,} | {median['expansions_a_second'] / PUBLIC[model]:.1f} "
        f"| {median['nodes_a_second']:,.0f} | {median['simulations_a_second']:.3g} "
        f"| {median['scenarios_a_leaf']:.1f} |"
    )


def main() -> None:
    """Measure all tasks and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--time", type=float, default=1.0)
    parser.add_argument("--steps", type=int, default=10)
    options = parser.parse_args()
    rows = []
    for model in PUBLIC:
        runs = [measure(model, seed, options.time, options.steps) for seed in range(1, options.runs + 1)]
        rows.append(row(model, runs))
        print(model, file=sys.stderr, flush=True)
    lines = [
        f"Machine: {machine()}. One process, one search thread. {options.runs} runs a model (seeds from 1), "
        f"up to {options.steps} steps each; median and range of the runs.",
        "",
        f"    {' '.join(command('MODEL', 1, options.time, options.steps))}",
        "",
        "| model | expansions/s | public DESPOT | ratio | nodes/s | simulations/s | scenarios a leaf |",
        "|---|---|---|---|---|---|---|",
        *rows,
    ]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
