# SPDX-License-Identifier: Apache-2.0
"""Plans many times with a solver and tells how well it keeps its deadline, and whether its memory grows.

python3 benchmarks/search/deadlines.py SOLVER --time 0.01 --plans 10000 [--mode parallel] [--options="..."]

SOLVER is a program that ``hypgen compile`` made; ``--options`` go to it. Needs nothing of hypgen's.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import shlex
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any


def resident(process: int) -> float:
    """Return the resident memory of a process, in MiB."""
    status = Path(f"/proc/{process}/status").read_text()
    found = re.search(r"^VmRSS:\s+(\d+) kB$", status, re.MULTILINE)
    return int(found[1]) / 1024 if found else math.nan


def quantile(values: list[float], share: float) -> float:
    """Return the smallest of sorted values that so large a share does not pass."""
    return values[max(0, math.ceil(share * len(values)) - 1)]


def plan(asked: argparse.Namespace) -> tuple[dict[str, Any], list[dict[str, Any]], list[float]]:
    """Return the run's line, those of its steps, and the memory after each hundredth of them."""
    # Episodes end when they do: so many are asked for that the plans are reached, and the rest is left.
    command = [str(asked.solver), "--time", str(asked.time), "--quiet", "--json", "-"]
    command += ["--runs", str(min(asked.plans, 1_000_000)), "--seed", str(asked.seed)]
    command += ["--mode", asked.mode] if asked.mode else []
    command += ["--threads", str(asked.threads)] if asked.threads else []
    run: dict[str, Any] = {}
    steps: list[dict[str, Any]] = []
    memory: list[float] = []
    command += shlex.split(asked.options)
    every = max(1, asked.plans // 100)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for text in process.stdout:
            line = json.loads(text)
            if line["type"] == "run":
                run = line
            if line["type"] != "step":
                continue
            steps.append(line)
            if len(steps) % every == 0:
                memory.append(resident(process.pid))
            if len(steps) == asked.plans:
                process.kill()
                break
    if not steps:
        sys.exit(f"{asked.solver} planned nothing")
    return run, steps, memory


def report(limit: float, run: dict[str, Any], steps: list[dict[str, Any]], memory: list[float]) -> None:
    """Print what there is to say."""
    overrun = sorted(1e3 * (step["search_seconds"] - limit) for step in steps)
    timed_out = sorted(1e3 * (s["search_seconds"] - limit) for s in steps if s["status"] == "deadline")
    late = [step["late_threads"] for step in steps if step["late_threads"] > 0]
    shown = [f"{run['model']}, mode {run['mode']}, {run['threads']} threads on {os.cpu_count()} cores"]
    shown += [f"{run['device']}, {limit:g} s a plan", f"{len(steps):,} plans"]
    print(", ".join(shown))
    print(f"ended with: {dict(Counter(step['status'] for step in steps))}")
    print("over the limit [ms; below 0: done sooner]:")
    for name, values in (("all plans", overrun), ("those that met the deadline", timed_out)):
        if values:
            figures = [f"p{100 * share:g} {quantile(values, share):.3f}" for share in (0.5, 0.99, 0.999)]
            print(f"  {name}: {', '.join(figures)}, worst {values[-1]:.3f}")
    over = sum(value > 1.0 for value in overrun)
    print(f"  plans more than 1 ms over: {over}")
    print(f"plans that left threads behind: {len(late)}, at most {max(late, default=0)} threads at a time")
    if memory:
        places = (0, len(memory) // 2, len(memory) - 1)
        start, middle, end = (memory[place] for place in places)
        print(f"resident memory [MiB]: start {start:.1f}, middle {middle:.1f}, end {end:.1f}")


def main() -> None:
    """Plan, then print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solver", type=Path)
    parser.add_argument("--time", type=float, default=0.01, help="limit of a plan in seconds (0.01)")
    parser.add_argument("--plans", type=int, default=10000, help="how many (10000)")
    parser.add_argument("--mode", help="of the solver (its default)")
    parser.add_argument("--threads", type=int, help="of modes with several (all cores)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--options", default="", help="of the solver")
    asked = parser.parse_args()
    report(asked.time, *plan(asked))


if __name__ == "__main__":
    main()
