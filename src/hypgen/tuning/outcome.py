# SPDX-License-Identifier: Apache-2.0
"""What a tuning has found: candidates, the winner, and what it earns in episodes of another seed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hypgen.experiments.results import Played
from hypgen.experiments.statistics import Difference, compare, mean_of
from hypgen.experiments.suite import Value
from hypgen.tuning.space import text_of


@dataclass(frozen=True)
class Tried:
    """A candidate: its values, its mean return over the episodes it has played, or why there is none.

    ``value`` is the mean; for a candidate that was ended early it is the best one's mean and the difference.
    """

    number: int
    values: Mapping[str, Value]
    episodes: int
    value: float
    problem: str = ""
    is_default: bool = False

    @property
    def is_done(self) -> bool:
        """Whether nothing more of it is played."""
        return bool(self.problem) or not math.isnan(self.value)

    def is_ended_early(self, runs: int) -> bool:
        """Whether it was clearly worse than the best before it had played so many episodes."""
        return self.is_done and not self.problem and self.episodes < runs

    def __str__(self) -> str:
        return " ".join(f"{name}={text_of(value)}" for name, value in self.values.items())


@dataclass(frozen=True)
class HeldOut:
    """Episodes that no candidate has played: by the default settings, the winner and the default policy."""

    default: Played
    winner: Played
    policy: Played | None

    @property
    def difference(self) -> Difference:
        """The winner's return minus that of the default settings, in the same episodes."""
        [found] = compare([(self.winner.returns, self.default.returns)])
        return found


@dataclass
class Outcome:
    """What is known. ``asked`` candidates of ``runs`` episodes were asked for.

    ``winner`` is the candidate that earned most, None where that is the default settings. ``settings`` are
    the winner's, as the solver takes them; ``file`` has them, if they were written.
    """

    asked: int
    runs: int
    default: Played | None = None
    tried: list[Tried] = field(default_factory=list)
    winner: Tried | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    held_out: HeldOut | None = None
    file: Path | None = None
    is_finished: bool = False

    @property
    def whole(self) -> list[Tried]:
        """The candidates that have played all episodes, the one that earned most first."""
        done = [one for one in self.tried if one.is_done and one.episodes == self.runs and not one.problem]
        return sorted(done, key=lambda one: -one.value)

    def verdict(self) -> str:
        """Return a line that says what is shown."""
        if self.held_out is None:
            return "no episodes were held out: nothing is shown" if self.is_finished else "not finished"
        difference = self.held_out.difference
        count = difference.interval.count
        if not difference.is_shown:
            return f"in {count} held-out episodes no difference is shown"
        word = "more" if difference.interval.mean > 0 else "less"
        return f"in {count} held-out episodes the tuned settings earn {word} than the default settings"


def candidates_markdown(outcome: Outcome, most: int = 5) -> str:
    """Return a table of the default settings and of the candidates that earned most."""
    lines = [("candidate", "episodes", "return"), ("---",) * 3]
    if outcome.default is not None:
        lines.append(
            (
                "default settings",
                str(len(outcome.default.returns)),
                str(mean_of(outcome.default.returns.values())),
            )
        )
    lines += [
        (f"{one.number}: {one}", str(one.episodes), f"{one.value:.3f}")
        for one in [one for one in outcome.whole if not one.is_default][:most]
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def held_out_markdown(held_out: HeldOut) -> str:
    """Return a table of the held-out episodes."""
    lines = [("held out", "episodes", "return", "minus default settings", "success"), ("---",) * 5]
    for name, played, difference in (
        ("default policy", held_out.policy, ""),
        ("default settings", held_out.default, ""),
        ("tuned settings", held_out.winner, str(held_out.difference)),
    ):
        if played is not None:
            success = f"{100 * played.success_rate:.1f} %" if played.successes else ""
            returned = str(mean_of(played.returns.values()))
            lines.append((name, str(len(played.returns)), returned, difference, success))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def settings_text(outcome: Outcome, about: Mapping[str, Any]) -> str:
    """Return the file of settings. ``found`` says where they come from; nothing reads it."""
    found: dict[str, Any] = dict(about)
    if outcome.held_out is not None:
        interval = outcome.held_out.difference.interval
        found["held_out"] = {
            "episodes": interval.count,
            "minus_default": interval.mean,
            "interval": [interval.low, interval.high],
            "is_shown": outcome.held_out.difference.is_shown,
        }
    return json.dumps({**outcome.settings, "found": found}, indent=2) + "\n"
