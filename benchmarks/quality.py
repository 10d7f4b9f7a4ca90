# SPDX-License-Identifier: Apache-2.0
"""Measure the return of each planning mode on the same episodes, for docs/results/quality_modes.md.

    python benchmarks/quality.py                 # all tasks, the settings of the published figures
    python benchmarks/quality.py tag --runs 20   # a quick look

Episode i has the same start and the same world in every mode (the world's random stream depends on the
seed and i alone), so modes are compared by paired differences. Each task's modes run as separate
processes, ``--jobs`` at a time; more jobs than idle cores would take planning time from the search. The
tables are printed; every episode's return goes to docs/results/data.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from hypgen.play.paired_statistics import differences, interval

ROOT = Path(__file__).resolve().parent.parent
# The solvers' lines. A finished mode is not run again: delete its file to measure anew.
KEPT = ROOT / "build" / "quality"
MODES = ("default", "despot", "rollout")


@dataclass(frozen=True)
class Task:
    """A model with the settings and published values that its row of the table cites."""

    name: str
    model: str
    runs: int
    options: tuple[str, ...]
    published: str
    modes: tuple[str, ...] = MODES


TASKS = (
    # Doors open for ever, so each episode has all 90 steps; the rest would be worth 0.95^90 * 19.37 = 0.19.
    Task(
        "tiger",
        "tiger.pomdp",
        5000,
        ("--trials", "200", "--steps", "90"),
        "V* 19.371 (SARSOP)",
        ("default", "despot"),
    ),
    Task(
        "rs_7_8",
        "rock_sample.pomdp",
        300,
        ("--time", "0.1", "--pruning", "0.05"),
        "SARSOP 21.5, DESPOT 20.9 (1 s)",
    ),
    Task(
        "rs_11_11",
        "rs_11_11.pomdp",
        300,
        ("--time", "0.1", "--pruning", "0.05"),
        "SARSOP 21.6, DESPOT 21.8 (1 s)",
    ),
    Task("tag", "tag.pomdp", 300, ("--time", "0.1"), "SARSOP -6.0, DESPOT -6.2 (1 s)"),
)


def command(task: Task, mode: str, runs: int, scenarios: int, seed: int) -> list[str]:
    """Return the command that runs ``task`` in ``mode``, without the output file."""
    return [
        "hypgen", "run", f"examples/{task.model}", "--mode", mode, "--runs", str(runs),
        "--scenarios", str(scenarios), "--seed", str(seed), *task.options,
    ]  # fmt: skip


def run(task: Task, mode: str, runs: int, scenarios: int, seed: int) -> dict[str, object]:
    """Run one mode of one task, or take an earlier run's lines, and return its episodes and summary."""
    arguments = command(task, mode, runs, scenarios, seed)
    lines = KEPT / f"{hashlib.sha256(' '.join(arguments).encode()).hexdigest()[:16]}.jsonl"
    if not lines.exists():
        KEPT.mkdir(parents=True, exist_ok=True)
        hypgen = Path(sys.executable).with_name("hypgen")
        arguments[0] = str(hypgen) if hypgen.exists() else "hypgen"
        partial = lines.with_suffix(".partial")
        subprocess.run([*arguments, "--quiet", "--json", str(partial)], cwd=ROOT, check=True)
        partial.rename(lines)
    records = [json.loads(line) for line in lines.read_text().splitlines()]
    episodes = [r for r in records if r["type"] == "episode"]
    steps = [r for r in records if r["type"] == "step"]
    summary = next(r for r in records if r["type"] == "summary")
    print(f"{task.name} {mode}: {len(episodes)} episodes", file=sys.stderr, flush=True)
    return {
        "returns": [e["discounted_return"] for e in episodes],
        "steps": statistics.fmean(e["steps"] for e in episodes),
        "statuses": {s: sum(e["status"] == s for e in episodes) for s in {e["status"] for e in episodes}},
        "lower": statistics.fmean(s["lower"] for s in steps if s["step"] == 0),
        "upper": statistics.fmean(s["upper"] for s in steps if s["step"] == 0),
        "summary": summary,
    }


def row(task: Task, mode: str, result: dict, baseline: dict) -> str:
    """Return one line of the table."""
    mean, half = interval(result["returns"])
    returns = [dict(enumerate(one["returns"])) for one in (result, baseline)]
    gain, gain_half = interval(differences(*returns))
    summary = result["summary"]
    rates = f"{summary['expansions_a_second']:.0f} | {summary['simulations_a_second']:.3g}"
    bounds = "-" if mode == "default" else f"{result['lower']:.2f}, {result['upper']:.2f}"
    paired = "-" if mode == "default" else f"{gain:+.2f} +- {gain_half:.2f}"
    return (
        f"| {task.name} | {mode} | {len(result['returns'])} | {mean:.3f} +- {half:.3f} | {paired} | {bounds} "
        f"| {result['steps']:.1f} | {rates} | {summary['scenarios_a_leaf']:.1f} | {task.published} |"
    )


def machine() -> str:
    """Return a line about this machine."""
    model = platform.processor() or platform.machine()
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else ():
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    return f"{model}, {os.cpu_count()} cores, {platform.system()}"


def main() -> None:
    """Run the chosen tasks, print the table of each and write its returns."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("tasks", nargs="*", help=f"of {', '.join(t.name for t in TASKS)}; all by default")
    parser.add_argument("--runs", type=int, help="episodes of each task instead of the table's")
    parser.add_argument("--scenarios", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "results" / "data")
    options = parser.parse_args()
    tasks = [t for t in TASKS if not options.tasks or t.name in options.tasks]
    jobs = [(t, m) for t in tasks for m in t.modes]
    with ThreadPoolExecutor(options.jobs) as pool:
        outcomes = pool.map(
            lambda j: run(j[0], j[1], options.runs or j[0].runs, options.scenarios, options.seed), jobs
        )
        results = {(t.name, m): outcome for (t, m), outcome in zip(jobs, outcomes, strict=True)}
    for task in tasks:
        write(task, {m: results[task.name, m] for m in task.modes}, options)


def write(task: Task, results: dict[str, dict], options: argparse.Namespace) -> None:
    """Print one task's table and write its raw returns."""
    runs = options.runs or task.runs
    lines = [
        f"## {task.name}",
        "",
        f"Machine: {machine()}; {options.jobs} solver process(es) at a time, each single-threaded. "
        f"K = {options.scenarios}, seed {options.seed}.",
        "",
        *(f"    {' '.join(command(task, m, runs, options.scenarios, options.seed))}" for m in task.modes),
        "",
        "| task | mode | runs | return | gain over default | root lower, upper | steps "
        "| expansions/s | simulations/s | scenarios a leaf | published |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
        *(row(task, m, results[m], results["default"]) for m in task.modes),
        "",
        *(f"Episode statuses, {m}: {results[m]['statuses']}" + "  " for m in task.modes),
    ]
    print("\n".join(lines))
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / f"quality_{task.name}.json").write_text(
        json.dumps({m: [round(v, 4) for v in results[m]["returns"]] for m in task.modes}) + "\n"
    )


if __name__ == "__main__":
    main()
