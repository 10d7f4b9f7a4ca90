# SPDX-License-Identifier: Apache-2.0
"""The episodes of settings: played unless they are kept, and never played twice."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from hypgen.experiments.cells import Cell
from hypgen.experiments.results import Played
from hypgen.experiments.running import Executor
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import Setting
from hypgen.tuning.asked import EPISODES_A_CELL
from hypgen.tuning.outcome import Outcome


class TimeIsUp(Exception):
    """The limit of a tuning is reached; what is played is kept."""


@dataclass
class State:
    """How far a tuning is: cells that are played, or left out, of at most ``total``; and what is known."""

    total: int
    done: int = 0
    outcome: Outcome | None = None


@dataclass
class Player:
    """Plays cells of one program. ``end`` is a time of ``time.monotonic()``."""

    program: str
    store: Store
    executor: Executor
    state: State
    end: float = float("inf")
    tell: Callable[[State], None] = field(default=lambda state: None)

    def play(self, settings: Sequence[Setting], first: int, runs: int) -> list[Played | str]:
        """Return what settings have earned in episodes ``first`` to ``first + runs - 1``, or why nothing."""
        cells = {
            setting: [Cell(setting, self.program, start, min(EPISODES_A_CELL, first + runs - start))
                      for start in range(first, first + runs, EPISODES_A_CELL)]
            for setting in settings
        }  # fmt: skip
        waves = [cell for wave in zip(*cells.values(), strict=True) for cell in wave]
        problems = self._play({cell.key: cell for cell in waves if not self.store.has(cell)})
        return [problems.get(setting) or self._played(cells[setting]) for setting in settings]

    def _play(self, missing: dict[str, Cell]) -> dict[Setting, str]:
        """Play cells; return why those of some settings could not be played."""
        problems: dict[Setting, str] = {}
        if not missing:
            return problems
        if time.monotonic() >= self.end:
            raise TimeIsUp
        playing = self.executor.play(list(missing.values()), self.store, self.end)
        try:
            for outcome in playing:
                if isinstance(outcome, Failure):
                    problems[outcome.cell.setting] = outcome.problem
                self.state.done += 1
                self.tell(self.state)
                missing.pop((outcome.cell if isinstance(outcome, Failure) else outcome).key, None)
        finally:
            close = getattr(playing, "close", None)
            if close is not None:
                close()
        if any(one.setting not in problems for one in missing.values()):
            raise TimeIsUp
        return problems

    def _played(self, cells: Sequence[Cell]) -> Played:
        played = Played(sum(cell.runs for cell in cells))
        for cell in cells:
            played.take(self.store.lines(cell))
        return played

    def options(self, setting: Setting, runs: int) -> dict[str, object]:
        """Return the options that the first cell of a played setting was played with."""
        cell = Cell(setting, self.program, 0, min(EPISODES_A_CELL, runs))
        return next(line for line in self.store.lines(cell) if line["type"] == "run")
