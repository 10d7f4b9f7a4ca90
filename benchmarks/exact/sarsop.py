# SPDX-License-Identifier: Apache-2.0
"""Lets scikit-decide's SARSOP play beside the vectors of ``hypgen solve``, in the same episodes.

python benchmarks/exact/sarsop.py MODEL [--set NAME=VALUE] [--runs 500] [--time 60] [--seed 0]

Needs hypgen and scikit-decide 1.1 or newer (``pip install scikit-decide``) in one environment. SARSOP gets
the enumerated model, its states split as for ``hypgen export``. It solves it for ``--time`` seconds or to the
relative gap of ``hypgen solve``. Its alpha vectors then act on hypgen's exact belief, as hypgen's own do.
Prints the table of ``hypgen compare`` and the bounds that each solver states. The discount is below 1.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hypgen.codegen.generate import generate_exact
from hypgen.dsl import load
from hypgen.play.played_programs import (
    Comparison,
    Policy,
    lines_of,
    outwards,
    play_exact,
    steps_needed,
    table,
)
from hypgen.runtime.builder.solver import build_solver

DOMAIN = Path(__file__).with_name("sarsop_domain.py")
GAP = 1e-3  # at which SARSOP stops, relative to a value above 1, like `hypgen solve`
SECONDS_BESIDE = 120  # to read the model and write vectors


def play_sarsop(
    program: Path, seconds: float, episodes: list[str], comparison: Comparison
) -> dict[str, Any] | None:
    """Let SARSOP's vectors play the episodes; return the bounds that it states, None if it fails."""
    policy = comparison.add("sarsop")
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            _run([str(program), f"--dump={folder / 'model.jsonl'}", "--quiet"], None)
            bounds = _solve(folder, seconds, comparison.solved)
            play = [f"--load-policy={folder / 'policy'}", *episodes, "--json", "-", "--quiet"]
            for line in lines_of([str(program), *play]):
                policy.take(line)
    except RuntimeError as error:
        policy.problem = str(error)
        return None
    return bounds


def _solve(folder: Path, seconds: float, proven: dict[str, Any] | None) -> dict[str, Any]:
    """Solve in a process of its own, which can be stopped: SARSOP overruns its limit."""
    size = max(1.0, abs(proven["lower"]), abs(proven["upper"])) if proven else 1.0
    child = [sys.executable, str(DOMAIN), str(folder), repr(seconds), repr(GAP * size)]
    _run(child, 2 * seconds + SECONDS_BESIDE)
    bounds: dict[str, Any] = json.loads((folder / "bounds.json").read_text(encoding="utf-8"))
    return bounds


def _run(command: list[str], most_seconds: float | None) -> None:
    """Run a program to its end; raises RuntimeError with the last line that it said if it fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=most_seconds)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"stopped after {most_seconds:.0f} s") from None
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise RuntimeError(said[-1] if said else f"exit code {done.returncode}")


def _ignore(policy: Policy) -> None:
    """Show nothing of the progress."""


def main() -> int:
    """Play and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("--set", dest="settings", metavar="NAME=VALUE", action="append", default=[])
    parser.add_argument("--runs", type=int, default=500, help="episodes (500)")
    parser.add_argument("--time", type=float, default=60.0, help="seconds to solve, for each solver (60)")
    parser.add_argument("--seed", type=int, default=0, help="of the episodes (0)")
    asked = parser.parse_args()
    loaded = load.load(asked.model, settings=tuple(asked.settings))
    program = build_solver(generate_exact(loaded.model), str(asked.model.absolute()), lambda step: None)
    steps = steps_needed(loaded.model.discount, loaded.model.horizon)
    episodes = [f"--runs={asked.runs}", f"--steps={steps}", f"--seed={asked.seed}"]
    comparison = Comparison()
    play_exact(program, ["alpha"], [*episodes, f"--time={asked.time}"], _ignore, comparison)
    stated = play_sarsop(program, asked.time, episodes, comparison)
    print(table(comparison.policies))
    if comparison.solved is not None:
        print(f"proven by hypgen: {outwards(comparison.solved['lower'], comparison.solved['upper'])}")
    if stated is not None:
        bounds = f"{stated['lower']:.6g} .. {stated['upper']:.6g}"
        print(f"stated by SARSOP: {bounds}, {stated['vectors']} vectors in {stated['seconds']:.1f} s")
    problems = [f"{policy.name}: {policy.problem}" for policy in comparison.policies if policy.problem]
    print(*problems, sep="\n", end="\n" if problems else "", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
