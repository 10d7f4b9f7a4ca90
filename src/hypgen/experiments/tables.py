# SPDX-License-Identifier: Apache-2.0
"""The tables of a suite: what each setting earned, and against what."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from hypgen.experiments.results import Played
from hypgen.experiments.statistics import Difference, Interval, compare, mean_of
from hypgen.experiments.suite import Setting, Study, Task


@dataclass(frozen=True)
class Row:
    """A setting's line. ``difference`` is from the setting that its group is compared with, if another."""

    setting: Setting
    played: Played
    returned: Interval
    promised: Interval
    difference: Difference | None


@dataclass(frozen=True)
class Table:
    """The settings of a study that play one task."""

    study: Study
    task: Task
    rows: tuple[Row, ...]

    @property
    def is_whole(self) -> bool:
        """Whether all episodes are played."""
        return all(len(row.played.returns) == self.study.runs for row in self.rows)


def tables_of(study: Study, played: Mapping[Setting, Played]) -> list[Table]:
    """Return a table for each task of a study. All comparisons of a table are adjusted for each other."""
    return [
        _table(study, task, [setting for setting in played if setting.task == task], played)
        for task in dict.fromkeys(setting.task for setting in played)
    ]


def _table(study: Study, task: Task, settings: Sequence[Setting], played: Mapping[Setting, Played]) -> Table:
    others = {setting: other for setting in settings if (other := _against(setting, settings, study.against))}
    found = compare([(played[one].returns, played[other].returns) for one, other in others.items()])
    differences = dict(zip(others, found, strict=True))
    return Table(
        study,
        task,
        tuple(
            Row(
                setting,
                played[setting],
                mean_of(played[setting].returns.values()),
                mean_of(played[setting].promised.values()),
                differences.get(setting),
            )
            for setting in settings
        ),
    )


def _against(setting: Setting, settings: Iterable[Setting], mode: str) -> Setting | None:
    """Return the setting of ``mode`` that shares most labels with ``setting``."""
    candidates = [one for one in settings if one.mode == mode and one != setting]
    if setting.mode == mode or not candidates:
        return None
    return max(candidates, key=lambda one: len(set(one.group) & set(setting.group)))


COLUMNS = (
    "setting", "episodes", "return", "minus", "promised", "success", "steps", "planning", "expansions a step",
    "searches",
)  # fmt: skip


def cells_of(table: Table) -> list[tuple[str, ...]]:
    """Return the texts of a table, a tuple a row."""
    varied = {
        name
        for row in table.rows
        for name, value in row.setting.labels
        if any(dict(other.setting.labels).get(name) != value for other in table.rows)
    }
    return [_texts(row, varied) for row in table.rows]


def _texts(row: Row, varied: set[str]) -> tuple[str, ...]:
    played = row.played
    shown = (f"{name} {value}" if name != "mode" else str(value) for name, value in row.setting.labels
             if name in varied or name == "mode")  # fmt: skip
    if not played.returns:
        return (", ".join(shown), "0", *([""] * (len(COLUMNS) - 3)), "; ".join(set(played.problems)))
    lengths = played.lengths.values()
    return (
        ", ".join(shown),
        str(len(played.returns)),
        str(row.returned),
        "" if row.difference is None else str(row.difference),
        "" if math.isnan(row.promised.mean) else f"{row.promised.mean:.3f}",
        "" if math.isnan(played.success_rate) else f"{100 * played.success_rate:.1f} %",
        f"{sum(lengths) / len(lengths):.1f}",
        f"{sum(played.seconds) / len(played.seconds):.3g} s" if played.seconds else "",
        f"{played.a_step('expansions'):,.1f}" if played.totals["expansions"] else "",
        _counts(played.searches) + ("; " + "; ".join(set(played.problems)) if played.problems else ""),
    )


def _counts(of: Counter[str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in sorted(of.items()))


def markdown(table: Table) -> str:
    """Return a table in Markdown."""
    columns = tuple(f"minus {table.study.against}" if name == "minus" else name for name in COLUMNS)
    lines = (columns, ("---",) * len(columns), *cells_of(table))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
