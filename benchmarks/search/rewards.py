# SPDX-License-Identifier: Apache-2.0
"""Compares what modes of solvers earn in the same episodes with the same time for each decision.

python3 benchmarks/search/rewards.py SOLVER [SOLVER ...] --keep FOLDER [--modes "despot,hyp --in-flight 512"]
    [--runs 100] [--time 0.05] [--threads 16] [--jobs 14] [--gpus 2] [--limit SECONDS]

SOLVER is a program that ``hypgen compile`` made. Episodes of one mode are played by several processes at a
time, each on cores (and a GPU) of its own. Run again, it plays only what is missing. Needs Python and nothing
of hypgen's.
"""

from __future__ import annotations

import argparse
import itertools
import shlex
import sys
from pathlib import Path
from typing import Any

import episodes
from episodes import Played, Setting

from hypgen.play.paired_statistics import differences, interval, with_interval

GPU_MODES = ("gpu", "hyp")
PIECES_A_WAVE = 5
COLUMNS = (
    "mode", "threads", "F", "episodes", "return", "steps", "expansions a step", "trials a step", "depth",
    "searches end with", "episodes end with",
)  # fmt: skip


def setting(solver: Path, text: str, asked: argparse.Namespace) -> Setting:
    """Return the setting of an item of --modes: a mode, and options that only it has."""
    mode, *own = shlex.split(text)
    threads = {"parallel": asked.threads, "hyp": asked.hyp_threads or asked.threads}.get(mode, 1)
    if "--threads" in own:
        threads = int(own[own.index("--threads") + 1])
    elif threads != 1:
        own += ["--threads", str(threads)]
    limits = ["--time", str(asked.time), "--steps", str(asked.steps), "--seed", str(asked.seed)]
    required = ["--require-gpu"] if mode in GPU_MODES else []
    options = ("--mode", mode, *limits, *shlex.split(asked.options), *own, *required)
    return Setting(text.strip(), solver, options, threads, bool(required))


def row(name: str, played: Played) -> list[str]:
    """Return a mode's line of the first table."""
    searched = played.total("expansions") > 0
    return [
        name, str(played.run.get("threads", "")), str(played.run.get("in_flight", "")),
        str(len(played.returns)), with_interval(played.returns.values()),
        f"{interval(played.lengths)[0]:.1f}",
        f"{played.mean('expansions'):,.1f}" if searched else "",
        f"{played.mean('trials'):,.1f}" if searched else "",
        f"{played.mean('max_depth'):.1f}" if searched else "",
        played.searches(), episodes.counts(played.endings),
    ]  # fmt: skip


def pairs(played: dict[str, Played]) -> str:
    """Return the table of differences: the mode of the line minus the mode of the column."""
    rows = [
        [name, *(with_interval(differences(ours.returns, theirs.returns), "+") if other != name else ""
                 for other, theirs in played.items())]
        for name, ours in played.items()
    ]  # fmt: skip
    return episodes.table(("minus", *played), rows)


def numbers(played: dict[str, Played]) -> dict[str, Any]:
    """Return what the JSON file has."""
    return {
        "modes": {
            name: {
                "run": one.run,
                "returns": one.returns,
                "return": interval(one.returns.values()),
                "steps": one.lengths,
                "endings": one.endings,
                "expansions_a_step": one.mean("expansions"),
            }
            for name, one in played.items()
        },
        "differences": {
            f"{a} - {b}": interval(differences(played[a].returns, played[b].returns))
            for a, b in itertools.permutations(played, 2)
        },
    }


def main() -> int:
    """Play what is missing and print the tables of each solver; return 1 if a mode could not be played."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solvers", nargs="+", type=Path)
    parser.add_argument("--runs", type=int, default=100, help="episodes (100)")
    parser.add_argument("--time", type=float, default=0.05, help="seconds a decision (0.05)")
    parser.add_argument(
        "--modes", default="default,rollout,despot,parallel,gpu,hyp", help="separated by commas"
    )
    parser.add_argument("--threads", type=int, default=16, help="of parallel and hyp (16)")
    parser.add_argument("--hyp-threads", type=int, help="of hyp (those of --threads)")
    episodes.add_options(parser)
    asked = parser.parse_args()
    settings = [setting(solver, text, asked) for solver in asked.solvers for text in asked.modes.split(",")]
    pieces = episodes.pieces_of(settings, asked.runs, PIECES_A_WAVE)
    problems = episodes.play(pieces, episodes.machine_for(asked), asked.keep, asked.limit)
    played = episodes.read(pieces, asked.keep)
    for solver in asked.solvers:
        # The order of --modes, and only what has been played.
        mine = {
            one.name: played[one] for one in settings if one.solver == solver and len(played[one].returns) > 0
        }
        page = (
            f"\n{solver.name}, {asked.time:g} s a decision, {next(iter(mine.values()), Played()).sizes()}; "
            "returns are discounted, +- is 95 %\n\n"
            f"{episodes.table(COLUMNS, (row(name, one) for name, one in mine.items()))}\n\n"
            f"The line's return minus the column's, in the same episodes:\n\n{pairs(mine)}"
        )
        episodes.publish(asked.keep, f"rewards_{solver.name}", page, numbers(mine))
    for problem in problems:
        episodes.say(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
