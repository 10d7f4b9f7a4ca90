# SPDX-License-Identifier: Apache-2.0
"""Plans many times with solvers and tells how late their decisions are, and whether their memory grows.

python3 benchmarks/search/deadlines.py SOLVER [SOLVER ...] --time 0.05 --plans 1000 --modes despot,parallel

A SOLVER is a program that ``hypgen compile`` made. Needs Python and taskset, nothing of hypgen's.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import shlex
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from queue import Queue
from typing import Any

COLUMNS = (
    "model",
    "mode",
    "threads",
    "plans",
    "p50",
    "p99",
    "p99.9",
    "worst",
    "over 1 ms",
    "belief: p50",
    "worst ",
    "MiB: start",
    "end",
)
THREADED = ("parallel", "hyp")


@dataclass
class Played:
    """What one or more processes have planned."""

    steps: list[dict[str, Any]] = field(default_factory=list)
    memory: list[float] = field(default_factory=list)  # MiB
    problem: str = ""


def resident(process: int) -> float:
    """Return the resident memory of a process, in MiB."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return math.nan
    found = re.search(r"^VmRSS:\s+(\d+) kB$", status, re.MULTILINE)
    return int(found[1]) / 1024 if found else math.nan


def quantile(values: list[float], share: float) -> float:
    """Return the smallest of sorted values that so large a share does not pass."""
    return values[max(0, math.ceil(share * len(values)) - 1)]


def plan(solver: Path, mode: str, threads: int, cores: str, asked: argparse.Namespace, seed: int) -> Played:
    """Return what a process plans until it has made so many plans, or for so many seconds."""
    # Episodes end when they do: so many are asked for that the plans are reached, and the rest is left.
    command = ["taskset", "-c", cores, str(solver), "--time", str(asked.time), "--quiet", "--json", "-"]
    command += ["--runs", str(min(asked.plans, 1_000_000)), "--seed", str(seed), "--mode", mode]
    command += ["--threads", str(threads)] if mode in THREADED else []
    command += ["--require-gpu"] if mode in ("gpu", "hyp") else []
    command += shlex.split(asked.options)
    played = Played()
    end = time.monotonic() + asked.limit
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        for text in process.stdout:
            line = json.loads(text)
            if line["type"] != "step":
                continue
            played.steps.append(line)
            if len(played.steps) % 10 == 0:
                played.memory.append(resident(process.pid))
            if len(played.steps) == asked.plans or time.monotonic() > end:
                process.kill()
                break
        else:
            played.problem = process.stderr.read().strip().split("\n")[0]
    return played


def row(solver: Path, mode: str, threads: int, cores: str, asked: argparse.Namespace) -> list[str]:
    """Return a row of the table: that of so many processes together on the same cores."""
    with ThreadPoolExecutor(asked.together) as pool:
        seeds = range(asked.seed, asked.seed + asked.together)
        played = list(pool.map(lambda seed: plan(solver, mode, threads, cores, asked, seed), seeds))
    steps = [step for one in played for step in one.steps]
    start = [solver.name, mode, str(threads if mode in THREADED else 1)]
    if not steps:
        return [*start, next((one.problem for one in played if one.problem), "nothing was planned")]
    late = sorted(1e3 * (step["search_seconds"] - asked.time) for step in steps)
    belief = sorted(1e3 * step["update_seconds"] for step in steps)
    figures = [f"{quantile(late, share):.2f}" for share in (0.5, 0.99, 0.999, 1.0)]
    figures.append(str(sum(value > 1.0 for value in late)))
    figures += [f"{quantile(belief, share):.2f}" for share in (0.5, 1.0)]
    memory = [value for one in played for value in one.memory] or [math.nan]
    return [*start, f"{len(steps):,}", *figures, f"{memory[0]:.0f}", f"{memory[-1]:.0f}"]


def main() -> None:
    """Plan, then print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solvers", type=Path, nargs="+", metavar="SOLVER")
    parser.add_argument("--time", type=float, default=0.01, help="limit of a plan in seconds (0.01)")
    parser.add_argument("--plans", type=int, default=10000, help="of a process, at most (10000)")
    parser.add_argument("--limit", type=float, default=math.inf, help="seconds of a process, at most")
    parser.add_argument("--modes", default="despot", help="a list with commas (despot)")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="of modes with several")
    parser.add_argument("--together", type=int, default=1, help="processes that share the cores of one (1)")
    parser.add_argument("--one-core", action="store_true", help="give a process with threads one core only")
    parser.add_argument("--jobs", type=int, default=1, help="rows at a time, each with cores of its own (1)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--options", default="", help="of the solver")
    asked = parser.parse_args()
    every = sorted(os.sched_getaffinity(0))
    has_threads = not asked.one_core and any(mode in THREADED for mode in asked.modes.split(","))
    wide = min(asked.threads, len(every)) if has_threads else 1
    places: Queue[list[int]] = Queue()
    for job in range(min(asked.jobs, len(every) // wide)):
        places.put(every[job * wide : (job + 1) * wide])

    def measure(of: tuple[Path, str]) -> list[str]:
        cores = places.get()
        try:
            used = cores if of[1] in THREADED else cores[:1]
            return row(*of, asked.threads, ",".join(map(str, used)), asked)
        finally:
            places.put(cores)

    print(f"milliseconds after a limit of {asked.time:g} s; {asked.together} processes on the same cores\n")
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")
    with ThreadPoolExecutor(places.qsize()) as pool:
        todo = [(solver, mode) for solver in asked.solvers for mode in asked.modes.split(",")]
        for found in pool.map(measure, todo):
            print(f"| {' | '.join(found)} |", flush=True)


if __name__ == "__main__":
    main()
