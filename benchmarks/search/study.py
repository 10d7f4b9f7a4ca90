# SPDX-License-Identifier: Apache-2.0
"""Compares reward and root gap of searches by many threads and by one, and with other settings.

python3 benchmarks/search/study.py SOLVER [SOLVER ...] --keep FOLDER --trials 500 [--threads 1,2,4,8,16]
    [--in-flight 0,64] [--observation-loss 1,0.5] [--exploration 0,0.1] [--xi 0.95] [--axes] [--mode parallel]
    [--runs 20] [--jobs 8] [--limit SECONDS]

SOLVER is a program that ``hypgen compile`` made. The first value of each list makes the setting that all are
compared with. N threads have N cores of their own. Run again, it plays only what is missing. Needs Python and
nothing of hypgen's.
"""

from __future__ import annotations

import argparse
import itertools
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import episodes
from episodes import Played, Setting

from hypgen.play.paired_statistics import differences, interval, with_interval

# The axes and the solver's options, in the order of a setting's values.
OPTIONS = ("--threads", "--in-flight", "--observation-loss", "--exploration", "--xi")
COLUMNS = (
    "threads", "F", "c_o", "c_a", "xi", "episodes", "return", "against the first", "first gap",
    "of the first's", "gap", "depth", "expansions a step", "trials a step", "trials/s", "against the first's",
    "collisions",
)  # fmt: skip


@dataclass(frozen=True)
class Point:
    """A setting's values of the axes."""

    threads: float
    in_flight: float
    observation_loss: float
    exploration: float
    xi: float

    def values(self) -> tuple[float, ...]:
        """Return them in the order of OPTIONS."""
        return (self.threads, self.in_flight, self.observation_loss, self.exploration, self.xi)


def points(axes: list[list[float]], one_at_a_time: bool, base_in_flight: int) -> list[Point]:
    """Return the settings, the first values' first, each once.

    Settings that search alike are one: fewer trials in flight than threads are as many as threads, and a
    single trial in flight meets no other, so the loss for those does not matter.
    """
    firsts = [values[0] for values in axes[1:]]
    distinct: dict[Point, None] = {}
    for threads, *others in itertools.product(*axes):
        if one_at_a_time and sum(value != first for value, first in zip(others, firsts, strict=True)) > 1:
            continue
        in_flight, loss, exploration, xi = others
        in_flight = max(in_flight or base_in_flight, threads)
        loss = firsts[1] if in_flight == 1 else loss
        distinct[Point(threads, in_flight, loss, exploration, xi)] = None
    return list(distinct)


def setting(solver: Path, point: Point, missing: set[str], asked: argparse.Namespace) -> Setting:
    """Return what a solver is told to search as a point says."""
    own = [
        text
        for option, value in zip(OPTIONS, point.values(), strict=True)
        if option not in missing
        for text in (option, f"{value:g}")
    ]
    limits = ["--trials", str(asked.trials)] if asked.trials else []
    limits += ["--time", str(asked.time)] if asked.time else []
    limits += ["--steps", str(asked.steps), "--seed", str(asked.seed)]
    wants_gpu = asked.mode in ("gpu", "hyp")
    required = ["--require-gpu"] if wants_gpu else []
    options = ("--mode", asked.mode, *limits, *shlex.split(asked.options), *own, *required)
    return Setting(" ".join(own), solver, options, int(point.threads), wants_gpu)


def settings_of(solver: Path, asked: argparse.Namespace) -> dict[Setting, Point]:
    """Return a solver's settings and what they stand for."""
    axes = [asked.threads, asked.in_flight, asked.observation_loss, asked.exploration, asked.xi]
    missing = {"--threads"} if asked.mode == "gpu" else set()
    if not episodes.knows(solver, "--exploration"):  # it searches as with 0
        missing.add("--exploration")
        if asked.exploration != [0.0]:
            episodes.say(f"{solver.name} has no --exploration: that axis is left out")
        axes[3] = [0.0]
    base = {"gpu": 64, "hyp": 256}.get(asked.mode, 1)
    return {setting(solver, point, missing, asked): point for point in points(axes, asked.axes, base)}


def gaps(played: Played, only_first: bool) -> dict[int, float]:
    """Return the mean gap between the root's bounds in each episode, of its first decision or of all."""
    found: dict[int, list[float]] = {}
    for step in played.steps:
        is_wanted = step["step"] == 0 or not only_first
        if is_wanted and step["upper"] is not None:
            found.setdefault(step["episode"], []).append(step["upper"] - step["lower"])
    return {episode: interval(values)[0] for episode, values in found.items()}


def measure(played: Played, first: Played) -> dict[str, Any]:
    """Return a setting's figures, intervals as pairs of mean and half-width."""
    ours, theirs = gaps(played, True), gaps(first, True)
    common = ours.keys() & theirs.keys()
    base = sum(theirs[episode] for episode in common)
    return {
        "episodes": len(played.returns),
        "return": interval(played.returns.values()),
        "difference": interval(differences(played.returns, first.returns)),
        "first_gap": interval(ours.values()),
        # Of sums, as a gap may be 0 in an episode.
        "first_gap_ratio": sum(ours[episode] for episode in common) / base if base > 0 else None,
        "first_gap_difference": interval(differences(ours, theirs)),
        "gap": interval(gaps(played, False).values()),
        "depth": played.mean("max_depth"),
        "expansions_a_step": played.mean("expansions"),
        "trials_a_step": played.mean("trials"),
        "trials_a_second": played.rate("trials"),
        "collisions_an_expansion": played.mean("collisions") / max(1e-9, played.mean("expansions")),
    }


def row(point: Point, played: Played, first: Played) -> list[str]:
    """Return a setting's line of the table."""
    figures = measure(played, first)
    ratio = figures["first_gap_ratio"]
    speed = figures["trials_a_second"] / max(1e-9, first.rate("trials"))
    return [
        *(f"{value:g}" for value in point.values()),
        str(figures["episodes"]), with_interval(played.returns.values()),
        "" if played is first else with_interval(differences(played.returns, first.returns), "+"),
        f"{figures['first_gap'][0]:.4g}", "" if ratio is None else f"{ratio:.3f}",
        f"{figures['gap'][0]:.4g}", f"{figures['depth']:.1f}",
        f"{figures['expansions_a_step']:,.0f}", f"{figures['trials_a_step']:,.0f}",
        f"{figures['trials_a_second']:,.0f}", f"{speed:.2f}", f"{figures['collisions_an_expansion']:.3f}",
    ]  # fmt: skip


def report(solver: Path, played: dict[Point, Played], first: Played, asked: argparse.Namespace) -> None:
    """Print and write what a solver's settings came to."""
    each = [f"{asked.trials} trials"] if asked.trials else []
    each += [f"{asked.time:g} s"] if asked.time else []
    page = (
        f"\n{solver.name}, mode {asked.mode}, {' and '.join(each)} a decision, {first.sizes()}; "
        "+- is 95 %, gaps are the root's, the first decision's where all settings have the same belief\n\n"
        + episodes.table(COLUMNS, (row(point, one, first) for point, one in played.items()))
    )
    data = [
        {**vars(point), **measure(one, first), "returns": one.returns, "run": one.run}
        for point, one in played.items()
    ]
    episodes.publish(asked.keep, f"study_{solver.name}_{asked.mode}", page, data)


def numbers(text: str) -> list[float]:
    """Return the numbers of a list separated by commas."""
    return [float(part) for part in text.split(",")]


def parse() -> argparse.Namespace:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solvers", nargs="+", type=Path)
    parser.add_argument("--mode", default="parallel", choices=("parallel", "gpu", "hyp"))
    parser.add_argument("--runs", type=int, default=20, help="episodes of each setting (20)")
    parser.add_argument("--trials", type=int, help="of a decision")
    parser.add_argument("--time", type=float, help="seconds a decision")
    parser.add_argument("--threads", type=numbers, default=[1.0, 2.0, 4.0, 8.0, 16.0])
    parser.add_argument("--in-flight", type=numbers, default=[0.0], help="0: the mode's default (0)")
    parser.add_argument("--observation-loss", type=numbers, default=[1.0], help="c_o (1)")
    parser.add_argument("--exploration", type=numbers, default=[0.0], help="c_a (0)")
    parser.add_argument("--xi", type=numbers, default=[0.95])
    parser.add_argument("--axes", action="store_true", help="for each number of threads vary one at a time")
    episodes.add_options(parser)
    asked = parser.parse_args()
    if not asked.trials and not asked.time:
        parser.error("one of --trials and --time is needed")
    if asked.mode == "gpu":
        asked.threads = [1.0]
    return asked


def main() -> int:
    """Play what is missing and print each solver's table; return 1 if a setting could not be played."""
    asked = parse()
    settings = {solver: settings_of(solver, asked) for solver in asked.solvers}
    pieces = episodes.pieces_of([one for mine in settings.values() for one in mine], asked.runs)
    problems = episodes.play(pieces, episodes.machine_for(asked), asked.keep, asked.limit)
    played = episodes.read(pieces, asked.keep)
    for solver, mine in settings.items():
        first = played[next(iter(mine))]
        report(solver, {mine[one]: played[one] for one in mine if played[one].returns}, first, asked)
    for problem in problems:
        episodes.say(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
