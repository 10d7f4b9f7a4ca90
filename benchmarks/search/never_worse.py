# SPDX-License-Identifier: Apache-2.0
"""Asks of solvers whether a search ever earns less than what it starts from, in the same time.

python3 benchmarks/search/never_worse.py SOLVER [SOLVER ...] --keep FOLDER [--times 0.03,0.1,1]
    [--modes despot,parallel] [--runs 30] [--threads 2] [--jobs 2] [--limit SECONDS]

A search starts from the default policy and from one-ply rollouts of it. The script plays the same episodes
in all modes and names each search that lies below one of the two by more than the 95 % interval of the
paired difference. It returns 1 if there is one. SOLVER is a program that ``hypgen compile`` made. Run again,
the script plays only what is missing.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

import episodes
from episodes import Played, Setting

from hypgen.play.paired_statistics import differences, interval, with_interval

PARTS = ("default", "rollout")  # what a search starts from
COLUMNS = ("model", "time [s]", "episodes", *PARTS, "mode", "return", "less default", "less rollout", "")


def setting(solver: Path, mode: str, seconds: str, asked: argparse.Namespace) -> Setting:
    """Return a mode with a time for each decision."""
    threads = asked.threads if mode in ("parallel", "hyp") else 1
    options = ["--mode", mode, "--steps", str(asked.steps), "--seed", str(asked.seed)]
    options += shlex.split(asked.options)
    if mode == PARTS[0]:  # it plans nothing, and so plays once for all times
        return Setting(mode, solver, tuple(options))
    wants_gpu = mode in ("gpu", "hyp")
    options += ["--time", seconds, *(["--threads", str(threads)] if threads > 1 else [])]
    options += ["--require-gpu"] if wants_gpu else []
    return Setting(f"{mode}, {seconds} s", solver, tuple(options), threads, wants_gpu)


def is_worse(ours: Played, theirs: Played) -> bool:
    """Return whether we earn less by more than the interval."""
    mean, half = interval(differences(ours.returns, theirs.returns))
    return mean + half < 0


def main() -> int:
    """Play what is missing, and print the table; return 1 if a search is worse than its parts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solvers", nargs="+", type=Path)
    parser.add_argument("--runs", type=int, default=30, help="episodes (30)")
    parser.add_argument("--times", default="0.03,0.1,1", help="seconds a decision, separated by commas")
    parser.add_argument("--modes", default="despot,parallel", help="searches, separated by commas")
    parser.add_argument("--threads", type=int, default=2, help="of parallel and hyp (2)")
    episodes.add_options(parser)
    asked = parser.parse_args()
    modes, times = asked.modes.split(","), asked.times.split(",")
    settings = {
        (solver, mode, seconds): setting(solver, mode, seconds, asked)
        for solver in asked.solvers
        for seconds in times
        for mode in (*PARTS, *modes)
    }
    pieces = episodes.pieces_of(dict.fromkeys(settings.values()), asked.runs)
    problems = episodes.play(pieces, episodes.machine_for(asked), asked.keep, asked.limit)
    played = episodes.read(pieces, asked.keep)
    rows, worse = [], []
    for solver in asked.solvers:
        for seconds in times:
            default, rollout = (played[settings[solver, part, seconds]] for part in PARTS)
            for mode in modes:
                ours = played[settings[solver, mode, seconds]]
                below = [
                    part
                    for part, theirs in zip(PARTS, (default, rollout), strict=True)
                    if is_worse(ours, theirs)
                ]
                worse += [f"{solver.name}, {mode}, {seconds} s: below {part}" for part in below]
                rows.append(
                    [
                        solver.name,
                        seconds,
                        str(len(ours.returns)),
                        with_interval(default.returns.values()),
                        with_interval(rollout.returns.values()),
                        mode,
                        with_interval(ours.returns.values()),
                        with_interval(differences(ours.returns, default.returns), "+"),
                        with_interval(differences(ours.returns, rollout.returns), "+"),
                        "**below**" if below else "",
                    ]
                )
    returns = {f"{one.solver.name}, {one.name}": played[one].returns for one in settings.values()}
    episodes.publish(asked.keep, "never_worse", episodes.table(COLUMNS, rows), {"returns": returns})
    for line in problems + worse:
        episodes.say(line)
    return 1 if problems or worse else 0


if __name__ == "__main__":
    sys.exit(main())
