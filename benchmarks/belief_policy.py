# SPDX-License-Identifier: Apache-2.0
"""Measures two-robot RockSample's belief policy: alone, and with one-ply rollouts from it.

    python benchmarks/belief_policy.py                          # (20,20): 100 layouts, 10 episodes each
    python benchmarks/belief_policy.py --size 11 --layouts 20   # a quick look at (11,11)

The search is limited by trials, so that other work on the machine does not change what it finds. Layouts
that are done stay in build/belief_policy and are not played again; delete the file to measure anew.

Rocks lie on distinct cells off the starts, drawn anew for each layout, as the paper has it. Episode i of
a layout has the same rocks and the same world in every mode, so that modes are compared by paired
differences.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import statistics
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = ROOT / "build" / "belief_policy"
MODEL = ROOT / "examples" / "two_robot_rock_sample.pomdp"


def layout(size: int, seed: int) -> dict[str, list[int]]:
    """Return the params of one layout of RockSample(size, size)."""
    starts = [size // 2 + 1, size // 2 - 1]
    free = [(x, y) for x in range(size) for y in range(size) if x > 0 or y not in starts]
    cells = random.Random(seed).sample(free, size)
    return {"start_row": starts, "rock_x": [x for x, _ in cells], "rock_y": [y for _, y in cells]}


def play(solver: str, options: list[str], params: Path, runs: int, seed: int) -> list[float]:
    """Return the discounted returns of the episodes of one layout."""
    command = [solver, *options, "--param", str(params), "--runs", str(runs), "--seed", str(seed), "--quiet"]
    out = subprocess.run([*command, "--json", "-"], check=True, capture_output=True, text=True).stdout
    lines = [json.loads(line) for line in out.splitlines()]
    return [line["discounted_return"] for line in lines if line["type"] == "episode"]


def lines_of(file: Path) -> list[str]:
    """Return the lines of a file, none if it is not there."""
    return file.read_text().splitlines() if file.exists() else []


def interval(values: list[float]) -> str:
    """Return the mean and half of its 95 % interval."""
    half = 1.96 * statistics.stdev(values) / math.sqrt(len(values))
    return f"{statistics.fmean(values):.2f} +- {half:.2f}"


def main() -> None:
    """Play, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--size", type=int, default=20, help="of the map, and the number of rocks")
    parser.add_argument("--layouts", type=int, default=100)
    parser.add_argument("--runs", type=int, default=10, help="episodes a layout")
    parser.add_argument("--trials", default="20", help="of the rollout mode a step; 0 leaves it out")
    parser.add_argument("--scenarios", default="4", help="of a trial")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    chosen = parser.parse_args()
    constants = [f"--set={name}={chosen.size}" for name in ("n", "k")]
    known = {"rock_x": [0] * chosen.size, "rock_y": [0] * chosen.size}  # the file's own have another length
    constants += [f"--set={name}={value}" for name, value in known.items()]
    command = ["hypgen", "compile", str(MODEL), *constants]
    solver = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()[-1]
    modes = {"default": ["--mode", "default"]}
    if chosen.trials != "0":
        rollout = ["--mode", "rollout", "--trials", chosen.trials, "--scenarios", chosen.scenarios]
        modes[f"rollout, {chosen.trials} trials of {chosen.scenarios}"] = rollout
    returns: dict[str, list[float]] = {}
    KEPT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(chosen.jobs) as pool:
        files = [Path(folder) / f"{seed}.json" for seed in range(chosen.layouts)]
        for seed, file in enumerate(files):
            file.write_text(json.dumps(layout(chosen.size, seed)))
        for name, options in modes.items():
            start = time.monotonic()
            kept = KEPT / f"{chosen.size}-{chosen.runs}-{name.replace(', ', '-').replace(' ', '-')}.jsonl"
            done = {line["layout"]: line["returns"] for line in map(json.loads, lines_of(kept))}
            tasks = {
                pool.submit(play, solver, options, f, chosen.runs, s): s
                for s, f in enumerate(files)
                if s not in done
            }
            with kept.open("a") as out:
                for task in as_completed(tasks):
                    done[tasks[task]] = task.result()
                    print(json.dumps({"layout": tasks[task], "returns": task.result()}), file=out, flush=True)
            returns[name] = [value for s in range(chosen.layouts) for value in done[s]]
            print(f"{name}: {interval(returns[name])} ({time.monotonic() - start:.0f} s)", flush=True)
    first, *others = returns.values()
    for name, values in zip(list(returns)[1:], others, strict=True):
        print(f"{name} minus default: {interval([b - a for a, b in zip(first, values, strict=True)])}")


if __name__ == "__main__":
    main()
