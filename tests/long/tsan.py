# SPDX-License-Identifier: Apache-2.0
"""Search with many threads under ThreadSanitizer, for long: python tests/long/tsan.py --minutes 20

Builds the solver of each example (all of examples/, or the files that are named) with ThreadSanitizer and
lets them plan in turn, in mode parallel, until together they have run for as long as asked. There are no
suppressions. Prints a line for each example; ends with 1 if there was a report, or a solver failed.
Solvers are kept in hypgen's cache: a second call builds nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.solver import build_solver

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
FLAGS = "-fsanitize=thread -g1"  # with lines for the reports
REPORT = re.compile(r"^WARNING: ThreadSanitizer: .*$", re.MULTILINE)
# What the turns differ in: plans that end before all threads are awake, searches that run out of memory,
# trials that queue, subtrees that are cut off, and trees of models with long rollouts.
VARIANTS = (
    ("--time", "0.05", "--steps", "20"),
    ("--time", "0.5", "--steps", "4"),
    ("--time", "0.2", "--steps", "8", "--memory", "8"),
    ("--time", "0.2", "--steps", "8", "--in-flight", "64"),
    ("--time", "0.2", "--steps", "8", "--pruning", "0.05"),
    ("--time", "0.2", "--steps", "8", "--exploration", "0.3"),
    ("--time", "3", "--trials", "200", "--steps", "3", "--scenarios", "10", "--depth", "15"),
)


@dataclass
class Tally:
    """What one example has done so far."""

    name: str
    solver: Path
    turns: int = 0
    seconds: float = 0.0
    decisions: int = 0
    expansions: int = 0
    reports: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def cells(self) -> tuple[str, ...]:
        """Return its line of the table."""
        counts = (self.turns, round(self.seconds), self.decisions, self.expansions)
        return (self.name, *map("{:,}".format, counts), str(len(self.reports)), str(len(self.failures)))


def build(examples: list[Path]) -> list[Tally]:
    """Return the examples' solvers, built one after another unless the cache has them."""
    os.environ["CXXFLAGS"] = f"{os.environ.get('CXXFLAGS', '')} {FLAGS}".strip()
    tallies = []
    for number, example in enumerate(examples):
        began = time.monotonic()
        solver = build_solver(generate(load(example).model), f"tsan/{example.stem}", lambda step: None)
        tallies.append(Tally(example.stem, solver))
        say(f"{number + 1}/{len(examples)} {example.stem}: built in {time.monotonic() - began:.0f} s")
    return tallies


def take_turn(tally: Tally, turn: int, options: argparse.Namespace) -> None:
    """Plan one episode and add up what came of it."""
    command = [str(tally.solver), "--mode", "parallel", "--threads", str(options.threads), "--runs", "1"]
    command += ["--scenarios", "100", "--particles", "500", "--memory", "256", "--seed", str(turn)]
    command += [*VARIANTS[turn % len(VARIANTS)], "--quiet", "--json", "-"]
    settings = {"TSAN_OPTIONS": "halt_on_error=0 second_deadlock_stack=1"}
    began = time.monotonic()
    try:
        done = subprocess.run(
            command, env=os.environ | settings, capture_output=True, text=True, timeout=options.patience
        )
    except subprocess.TimeoutExpired:
        done = subprocess.CompletedProcess(command, -1, "", f"still running after {options.patience} s")
    tally.turns += 1
    tally.seconds += time.monotonic() - began
    steps = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"type":"step"')]
    tally.decisions += len(steps)
    tally.expansions += sum(step["expansions"] for step in steps)
    found = REPORT.findall(done.stderr)
    tally.reports += found
    if done.returncode != 0 and not found:
        tally.failures.append(done.stderr.strip()[-300:])
    if done.returncode != 0:
        say(f"{' '.join(command)}\n{done.stderr[:20000]}")


def say(text: str) -> None:
    """Print progress, apart from the table."""
    print(text, file=sys.stderr, flush=True)


def main() -> int:
    """Build, run and print; return 1 if anything was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("examples", nargs="*", type=Path, help="model files (all examples)")
    parser.add_argument("--minutes", type=float, default=20.0, help="running, in all (20)")
    parser.add_argument("--threads", type=int, default=16, help="of a search (16)")
    parser.add_argument("--patience", type=float, default=600.0, help="seconds that a turn may take (600)")
    options = parser.parse_args()
    tallies = build(options.examples or sorted(EXAMPLES.rglob("*.pomdp")))
    turn = 0
    while (seconds := sum(tally.seconds for tally in tallies)) < 60 * options.minutes:
        say(f"turn {turn}, after {seconds:.0f} s, {sum(len(tally.reports) for tally in tallies)} reports")
        for tally in tallies:
            take_turn(tally, turn, options)
        turn += 1
    header = ("example", "turns", "seconds", "decisions", "expansions", "reports", "failures")
    total = Tally("all", Path())
    for tally in tallies:
        for name in ("turns", "seconds", "decisions", "expansions", "reports", "failures"):
            setattr(total, name, getattr(total, name) + getattr(tally, name))
    for cells in (header, ("---",) * len(header), *(tally.cells() for tally in (*tallies, total))):
        print("| " + " | ".join(cells) + " |")
    return 1 if total.reports or total.failures else 0


if __name__ == "__main__":
    sys.exit(main())
