# SPDX-License-Identifier: Apache-2.0
"""Plays programs for ``hypgen compare``: runs them and puts their episodes together."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from pathlib import Path
from typing import Any

from hypgen.play import signals
from hypgen.play.paired_statistics import differences, interval, with_interval

PLANNERS = ("default", "rollout", "despot", "parallel", "pomcp")
GPU_PLANNERS = ("gpu", "hyp")
EXACT = ("alpha", "qmdp", "blind")  # policies on the exact belief

COLUMNS = ("policy", "episodes", "return", "minus the best", "steps", "planning")
LEFT_OUT = 1e-3  # of the sum of discounts, where nothing is said about it
MOST_STEPS = 300  # of an episode, unless more are asked for


_BROKEN = 2  # the exit code of a program whose model or options are wrong


class BrokenModelError(RuntimeError):
    """A bound or reward of the model is no number, or the options are wrong."""


@dataclass
class Policy:
    """The episodes of one policy so far; ``problem`` says why there are no more."""

    name: str
    returns: dict[int, float] = field(default_factory=dict)
    steps: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)  # of planning, a step
    unsearched: int = 0  # steps in which there was no time to look ahead
    is_broken: bool = False  # the model is: what is known of it is no number somewhere
    problem: str = ""

    @property
    def mean(self) -> float:
        """Return the mean return."""
        return interval(self.returns.values())[0]

    def take(self, line: dict[str, Any]) -> None:
        """Take a line of a program's output."""
        if line["type"] == "step":
            self.seconds.append(line["search_seconds"])
            self.unsearched += line.get("looked") == "nowhere" and self.name != "default"
        elif line["type"] == "episode" and line["status"] != "interrupted":
            self.returns[line["episode"]] = line["discounted_return"]
            self.steps.append(line["steps"])


@dataclass
class Comparison:
    """What is known so far; an interrupt leaves it as it is.

    ``solved`` is what was proven of the best policy.
    """

    policies: list[Policy] = field(default_factory=list)
    solved: dict[str, Any] | None = None
    steps: int = 0  # most of an episode
    left_out: float = 0.0  # by episodes of so many steps, of the sum of discounts

    def add(self, name: str, problem: str = "") -> Policy:
        """Return a new policy, which has not played yet."""
        self.policies.append(Policy(name, problem=problem))
        return self.policies[-1]


def lines_of(command: Sequence[str], seconds: float | None = None) -> Iterator[dict[str, Any]]:
    """Yield a program's JSON lines; raise RuntimeError with what it said if it fails.

    A signal that ends a run reaches the program, which ends as it likes. After its last line this process
    gets the signal: Ctrl-C raises ``KeyboardInterrupt``. After ``seconds`` the program ends in the same way,
    and nothing is raised.
    """
    program = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0
    )
    with program as process, signals.passed_to(process) as received:
        assert process.stdout is not None and process.stderr is not None
        with _limiting(process, seconds) as is_over:
            for text in process.stdout:
                yield json.loads(text)
            complaint = process.stderr.read().strip()
    if received:
        signal.raise_signal(received[0])
    if process.returncode == _BROKEN:
        raise BrokenModelError(complaint)
    if process.returncode != 0 and not is_over.is_set():
        raise RuntimeError(complaint or f"exit code {process.returncode}")


@contextlib.contextmanager
def _limiting(process: subprocess.Popen[str], seconds: float | None) -> Iterator[threading.Event]:
    """End a program once its time is over, and tell so."""
    is_over = threading.Event()

    def stop() -> None:
        is_over.set()
        process.send_signal(signal.SIGTERM)  # a shell's background ignores SIGINT

    limit = threading.Timer(seconds or 0, stop)
    if seconds is not None:
        limit.start()
    try:
        yield is_over
    finally:
        limit.cancel()


def play_mode(solver: Path, policy: Policy, options: Sequence[str], show: Callable[[Policy], None]) -> None:
    """Play the episodes of a mode of a solver; ``show`` sees the policy after every episode."""
    required = ["--require-gpu"] if policy.name in ("gpu", "hyp") else []
    command = [str(solver), "--mode", policy.name, *required, *options, "--json", "-", "--quiet"]
    try:
        for line in lines_of(command):
            policy.take(line)
            if line["type"] == "episode":
                show(policy)
    except RuntimeError as error:
        policy.problem = str(error)
        policy.is_broken = isinstance(error, BrokenModelError)


def play_exact(
    program: Path,
    kinds: Sequence[str],
    options: Sequence[str],
    show: Callable[[Policy], None],
    comparison: Comparison,
) -> None:
    """Play the episodes of policies on the exact belief, and note what is proven of the value."""
    policies = {kind: comparison.add(kind) for kind in kinds}
    play = ["--policy-kind", ",".join(kinds)]
    try:
        for line in lines_of([str(program), *options, *play, "--json", "-", "--quiet"]):
            if line["type"] == "solve":
                comparison.solved = line
            elif line["type"] == "episode":
                policies[line["policy"]].take(line)
                show(policies[line["policy"]])
    except RuntimeError as error:
        for policy in policies.values():
            policy.problem = str(error)


def table(policies: Sequence[Policy]) -> str:
    """Return the table for people: a line for each policy that has played, in order."""
    played = [policy for policy in policies if policy.returns]
    best = _best(played)
    all_alike = len({len(policy.returns) for policy in played}) < 2
    rows = [COLUMNS]
    for policy in played:
        gain = "" if policy is best or best is None else _minus(policy, best)
        seconds = interval(policy.seconds)[0] if policy.seconds else None
        rows.append(
            (
                policy.name,
                "" if all_alike else str(len(policy.returns)),
                with_interval(policy.returns.values()),
                gain,
                f"{interval(policy.steps)[0]:.1f}",
                "" if seconds is None else f"{seconds * 1e3:.2f} ms",
            )
        )
    shown = [i for i, name in enumerate(COLUMNS) if name != "episodes" or not all_alike]
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    return "\n".join("  ".join(row[i].ljust(widths[i]) for i in shown).rstrip() for row in rows)


def _best(played: Sequence[Policy]) -> Policy | None:
    """Return the policy with the largest mean among those with the most episodes."""
    return max(played, key=lambda policy: (len(policy.returns), policy.mean), default=None)


def _minus(policy: Policy, best: Policy) -> str:
    return with_interval(differences(policy.returns, best.returns), "+")


def numbers(comparison: Comparison) -> dict[str, Any]:
    """Return all of the table as data, nan as None."""
    policies = comparison.policies
    best = _best([policy for policy in policies if policy.returns])

    def estimate(values: Iterable[float]) -> dict[str, float | None]:
        mean, half = interval(values)
        return {"mean": _known(mean), "half": _known(half)}

    return {
        "best": best.name if best else None,
        "policies": [
            {
                "name": policy.name,
                "return": estimate(policy.returns.values()),
                "minus_best": estimate(differences(policy.returns, best.returns)) if best else None,
                "steps": _known(interval(policy.steps)[0]),
                "planning_seconds": _known(interval(policy.seconds)[0]),
                "returns": [policy.returns[episode] for episode in sorted(policy.returns)],
                "unsearched": policy.unsearched,
                "problem": policy.problem or None,
            }
            for policy in policies
        ],
        "value": comparison.solved,
        "steps": comparison.steps,
        "left_out": comparison.left_out,
    }


def outwards(lower: float, upper: float) -> str:
    """Return an interval in six digits, rounded outwards: what is printed holds the value as well."""
    ends = ((lower, ROUND_FLOOR), (upper, ROUND_CEILING))
    return " .. ".join(f"{float(Context(6, way).create_decimal(end)):.6g}" for end, way in ends)


def _known(number: float) -> float | None:
    return number if number == number else None


def left_out(discount: float, horizon: int | None, steps: int) -> float:
    """Return which part of the sum of discounts is left out by episodes of so many steps."""
    if horizon is not None and steps >= horizon:
        return 0.0
    if discount == 1:
        return 1.0 if horizon is None else 1 - steps / horizon
    last = 0.0 if horizon is None else discount**horizon
    return float((discount**steps - last) / (1 - last))


def steps_needed(discount: float, horizon: int | None) -> int:
    """Return the fewest steps that leave out no more than ``LEFT_OUT``, up to ``MOST_STEPS``."""
    return next((n for n in range(1, MOST_STEPS) if left_out(discount, horizon, n) <= LEFT_OUT), MOST_STEPS)
