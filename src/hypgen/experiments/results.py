# SPDX-License-Identifier: Apache-2.0
"""What settings have played so far, read from the cells of a store."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any

from hypgen.experiments.cells import cells_of
from hypgen.experiments.measures import Measure
from hypgen.experiments.store import Named, Store, broken
from hypgen.experiments.suite import Setting, Study


@dataclass(frozen=True)
class Place:
    """Where a cell was played, and by what."""

    processor: str
    cores: int
    system: str
    device: str  # what evaluates leaves, as the solver calls it
    hypgen: str
    compiler: str


@dataclass
class Played:
    """The episodes of a setting, by number, and what its searches did. ``wanted`` episodes were asked for."""

    wanted: int = 0
    returns: dict[int, float] = field(default_factory=dict)
    lengths: dict[int, int] = field(default_factory=dict)
    successes: dict[int, bool] = field(default_factory=dict)  # where the model says
    promised: dict[int, float] = field(default_factory=dict)  # the first root's bounds' middle
    gaps: dict[int, float] = field(default_factory=dict)  # between the first root's bounds
    endings: Counter[str] = field(default_factory=Counter)
    searches: Counter[str] = field(default_factory=Counter)
    seconds: list[float] = field(default_factory=list)  # of planning, a step
    updates: list[float] = field(default_factory=list)  # seconds of the belief's update, a step
    totals: Counter[str] = field(default_factory=Counter)  # of the search's counts, over all steps
    places: Counter[Place] = field(default_factory=Counter)  # cells
    began: list[str] = field(default_factory=list)  # when each cell began, in ISO 8601
    measures: tuple[Measure, ...] = ()
    measured: dict[str, dict[int, float]] = field(default_factory=dict)  # of each measure, by episode
    crowded: int = 0  # cells that began on a machine with more to do than it has cores
    problems: list[str] = field(default_factory=list)

    def take(self, lines: Iterable[dict[str, Any]]) -> None:
        """Take the lines of a cell."""
        head: dict[str, Any] = {}
        actions = Counter[str]()  # of the present episode
        for line in lines:
            match line["type"]:
                case "cell":
                    head = line
                case "run":
                    self._take_place(head, line)
                case "step":
                    self._take_step(line)
                    actions[line["action_name"]] += 1
                case "episode":
                    episode = line["episode"]
                    self.returns[episode] = line["discounted_return"]
                    self.lengths[episode] = line["steps"]
                    self.endings[line["status"]] += 1
                    if line["success"] is not None:
                        self.successes[episode] = line["success"]
                    for one in self.measures:
                        self.measured.setdefault(one.name, {})[episode] = one.of(actions, line)
                    actions.clear()

    def _take_place(self, head: Mapping[str, Any], run: Mapping[str, Any]) -> None:
        machine = head["machine"]
        self.places[
            Place(
                machine["processor"],
                machine["cores"],
                machine["system"],
                run["device"],
                machine["hypgen"],
                head["compiler"],
            )
        ] += 1
        self.began.append(head["began"])
        self.crowded += head["load_average"][0] > machine["cores"] + 1

    def _take_step(self, line: Mapping[str, Any]) -> None:
        self.seconds.append(line["search_seconds"])
        self.updates.append(line["update_seconds"])
        self.searches[line["status"]] += 1
        for name in ("expansions", "nodes", "trials", "simulations", "max_depth", "collisions"):
            self.totals[name] += line[name]
        if line["step"] == 0 and line["upper"] is not None and line["lower"] is not None:
            self.promised[line["episode"]] = (line["upper"] + line["lower"]) / 2
            self.gaps[line["episode"]] = line["upper"] - line["lower"]

    @property
    def success_rate(self) -> float:
        """The share of episodes that succeeded; nan where the model does not say."""
        return fmean(self.successes.values()) if self.successes else math.nan

    def a_step(self, name: str) -> float:
        """Return a count's mean over all steps."""
        return self.totals[name] / len(self.seconds) if self.seconds else math.nan

    def a_second(self, name: str) -> float:
        """Return a count over the seconds of planning; nan where there is nothing to count."""
        seconds = sum(self.seconds)
        return self.totals[name] / seconds if self.totals[name] and seconds > 0.0 else math.nan


def read(study: Study, programs: dict[str, str], store: Store) -> dict[Setting, Played]:
    """Return what each setting of a study has played, in the study's order."""
    return read_cells(study, cells_by_setting(study, programs), store)


def cells_by_setting(study: Study, programs: dict[str, str]) -> dict[Setting, list[Named]]:
    """Return the cells of each setting; equal settings of a study have the same."""
    alone = (
        Study(study.name, (setting,), study.runs, study.against, study.episodes_a_cell)
        for setting in study.settings
    )
    return {one.settings[0]: list(cells_of([one], programs)) for one in alone}


def read_cells(study: Study, cells: Mapping[Setting, Sequence[Named]], store: Store) -> dict[Setting, Played]:
    """Return what each setting has played of its cells; raise ``SuiteError`` at what is no cell."""
    found: dict[Setting, Played] = {}
    for setting in study.settings:
        played = found[setting] = Played(study.runs, measures=study.measures)
        for cell in cells.get(setting, ()):
            if store.has(cell):
                try:
                    played.take(store.lines(cell))
                except (KeyError, TypeError, IndexError) as error:
                    raise broken(store.path(cell), f"{type(error).__name__}: {error}") from None
            elif problem := store.failure(cell):
                played.problems.append(problem)
    return found
