"""What ``hypgen compare`` does with programs that play: runs them and puts their episodes together."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from pathlib import Path
from typing import Any

from hypgen.cli.paired import differences, interval, with_interval

COLUMNS = ("policy", "return", "minus the best", "steps", "planning")


@dataclass
class Policy:
    """The episodes of one policy so far; ``problem`` says why there are no more."""

    name: str
    returns: dict[int, float] = field(default_factory=dict)
    steps: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)  # of planning, a step
    problem: str = ""

    @property
    def mean(self) -> float:
        """Return the mean return."""
        return interval(self.returns.values())[0]

    def take(self, line: dict[str, Any]) -> None:
        """Take a line of a program's output."""
        if line["type"] == "step":
            self.seconds.append(line["search_seconds"])
        elif line["type"] == "episode" and line["status"] != "interrupted":
            self.returns[line["episode"]] = line["discounted_return"]
            self.steps.append(line["steps"])


def lines_of(command: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield a program's JSON lines; raise RuntimeError with what it said if it fails."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        for text in process.stdout:
            yield json.loads(text)
        complaint = process.stderr.read().strip()
    if process.returncode != 0:
        raise RuntimeError(complaint or f"exit code {process.returncode}")


def play_modes(
    solver: Path, modes: Iterable[str], options: Sequence[str], show: Callable[[Policy], None]
) -> Iterator[Policy]:
    """Play the episodes of each mode of a solver; ``show`` sees each policy after every episode."""
    for mode in modes:
        policy = Policy(mode)
        required = ["--require-gpu"] if mode in ("gpu", "hyp") else []
        command = [str(solver), "--mode", mode, *required, *options, "--json", "-", "--quiet"]
        try:
            for line in lines_of(command):
                policy.take(line)
                if line["type"] == "episode":
                    show(policy)
        except RuntimeError as error:
            policy.problem = str(error)
        yield policy


def play_exact(
    program: Path, kinds: Sequence[str], options: Sequence[str], show: Callable[[Policy], None]
) -> tuple[list[Policy], dict[str, Any] | None]:
    """Play the episodes of policies on the exact belief; return them and what was proven of the value."""
    policies = {kind: Policy(kind) for kind in kinds}
    solved = None
    command = [str(program), "--policy-kind", ",".join(kinds), *options, "--json", "-", "--quiet"]
    try:
        for line in lines_of(command):
            if line["type"] == "solve":
                solved = line
            elif line["type"] == "episode":
                policies[line["policy"]].take(line)
                show(policies[line["policy"]])
    except RuntimeError as error:
        for policy in policies.values():
            policy.problem = str(error)
    return list(policies.values()), solved


def table(policies: Sequence[Policy]) -> str:
    """Return the table for people: a line for each policy that has played, in order."""
    played = [policy for policy in policies if policy.returns]
    best = max(played, key=lambda policy: policy.mean, default=None)
    rows = [COLUMNS]
    for policy in played:
        gain = "" if policy is best or best is None else _minus(policy, best)
        seconds = interval(policy.seconds)[0] if policy.seconds else None
        rows.append(
            (
                policy.name,
                with_interval(policy.returns.values()),
                gain,
                f"{interval(policy.steps)[0]:.1f}",
                "" if seconds is None else f"{seconds * 1e3:.2f} ms",
            )
        )
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def _minus(policy: Policy, best: Policy) -> str:
    return with_interval(differences(policy.returns, best.returns), "+")


def numbers(policies: Sequence[Policy], solved: dict[str, Any] | None) -> dict[str, Any]:
    """Return all of the table as data, nan as None."""
    played = [policy for policy in policies if policy.returns]
    best = max(played, key=lambda policy: policy.mean, default=None)

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
                "problem": policy.problem or None,
            }
            for policy in policies
        ],
        "value": solved,
    }


def outwards(lower: float, upper: float) -> str:
    """Return an interval in six digits, rounded outwards: what is printed holds the value as well."""
    ends = ((lower, ROUND_FLOOR), (upper, ROUND_CEILING))
    return " .. ".join(f"{float(Context(6, way).create_decimal(end)):.6g}" for end, way in ends)


def _known(number: float) -> float | None:
    return number if number == number else None
