# SPDX-License-Identifier: Apache-2.0
"""The tables of a suite: what each setting earned, and against what."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

from hypgen.experiments.results import Played
from hypgen.experiments.statistics import Difference, Interval, compare, difference_of, mean_of, share_of
from hypgen.experiments.suite import FIRST, Setting, Study, Task


@dataclass(frozen=True)
class Row:
    """A setting's line.

    ``differences`` are from the settings that its group is compared with, by their modes. ``excess`` is what
    the root promised minus what was earned, in the same episodes. ``gap`` is between the root's bounds in the
    first decision, where all settings have the same belief. ``speed_up`` is the ratio of expansions a second
    of planning to those of ``despot``.
    """

    setting: Setting
    played: Played
    returned: Interval
    promised: Interval
    excess: Interval
    success: Interval
    steps: Interval
    gap: Interval
    measured: Mapping[str, Interval]
    differences: Mapping[str, Difference]
    speed_up: float

    @property
    def promises_too_much(self) -> bool:
        """Whether the root promises more than is earned, and chance does not explain it."""
        return self.excess.is_known and self.excess.low > 0.0

    @property
    def is_below(self) -> list[str]:
        """The modes that are shown to earn more."""
        return [mode for mode, one in self.differences.items() if one.is_shown and one.interval.mean < 0.0]


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
    """Return a table for each task of a study. All comparisons of a table are adjusted for each other.

    What all others are compared with, and takes no option that varies, has one row.
    """
    return [
        _table(study, task, [setting for setting in played if setting.task == task], played)
        for task in dict.fromkeys(setting.task for setting in played)
    ]


def _table(study: Study, task: Task, settings: Sequence[Setting], played: Mapping[Setting, Played]) -> Table:
    others = {
        (setting, mode): other
        for setting in settings
        for mode in _compared(setting, study.against)
        if (other := _against(setting, settings, mode))
    }
    found = compare([(played[one].returns, played[other].returns) for (one, _), other in others.items()])
    differences: dict[Setting, dict[str, Difference]] = {}
    for (setting, mode), one in zip(others, found, strict=True):
        differences.setdefault(setting, {})[mode] = one
    rows = {setting.options: setting for setting in reversed(settings) if setting not in differences}
    shown = [setting for setting in settings if setting in differences or rows[setting.options] is setting]
    return Table(
        study,
        task,
        tuple(
            _row(setting, played[setting], differences.get(setting, {}), _speed_up(setting, settings, played))
            for setting in shown
        ),
    )


def _compared(setting: Setting, against: Sequence[str]) -> Sequence[str]:
    """Return the modes that a setting is compared with."""
    return against[: against.index(setting.mode)] if setting.mode in against else against


def _row(setting: Setting, played: Played, differences: Mapping[str, Difference], speed_up: float) -> Row:
    return Row(
        setting,
        played,
        mean_of(played.returns.values()),
        mean_of(played.promised.values()),
        difference_of(played.promised, played.returns),
        share_of(played.successes.values()),
        mean_of(played.lengths.values()),
        mean_of(played.gaps.values()),
        {one.name: mean_of(played.measured.get(one.name, {}).values()) for one in played.measures},
        differences,
        speed_up,
    )


def _speed_up(setting: Setting, settings: Sequence[Setting], played: Mapping[Setting, Played]) -> float:
    """Return how many times the expansions a second of ``despot`` with the same options a setting has."""
    other = _against(setting, settings, "despot")
    if other is None:
        return math.nan
    return played[setting].a_second("expansions") / played[other].a_second("expansions")


def _against(setting: Setting, settings: Sequence[Setting], mode: str) -> Setting | None:
    """Return the setting of ``mode`` that shares most labels with ``setting``, or the first of all."""
    if mode == FIRST:
        return None if setting == settings[0] else settings[0]
    candidates = [one for one in settings if one.mode == mode and one != setting]
    if setting.mode == mode or not candidates:
        return None
    return max(candidates, key=lambda one: len(set(one.group) & set(setting.group)))


def columns_of(table: Table) -> tuple[str, ...]:
    """Return the names of a table's columns."""
    minus = (f"minus {mode}" for mode in table.study.against)
    measured = (one.name for one in table.study.measures)
    left = ("setting", "episodes", "return", *minus, "promised", "success", *measured, "steps")
    return (*left, "planning", "expansions a step", "first gap", "searches")


def cells_of(table: Table) -> list[tuple[str, ...]]:
    """Return the texts of a table, a tuple a row."""
    varied = varied_in(table)
    return [_texts(row, varied, table.study) for row in table.rows]


def varied_in(table: Table) -> set[str]:
    """Return the labels that tell a table's rows apart."""
    return {
        name
        for row in table.rows
        for name, value in row.setting.labels
        if any(dict(other.setting.labels).get(name) != value for other in table.rows)
    }


def label_of(setting: Setting, varied: Set[str]) -> str:
    """Return a setting's mode and those of its options that vary and that it takes up."""
    told = dict(setting.options)
    names = [name for name, _ in setting.labels if name != "mode" and name in varied and name in told]
    return ", ".join([setting.mode, *(f"{name} {told[name]}" for name in names)])


def _texts(row: Row, varied: set[str], study: Study) -> tuple[str, ...]:
    played = row.played
    label = label_of(row.setting, varied)
    if not played.returns:
        empty = 7 + len(study.against) + len(study.measures)
        return (label, "0", *([""] * empty), "; ".join(set(played.problems)))
    lengths = played.lengths.values()
    return (
        label,
        str(len(played.returns)),
        str(row.returned),
        *(_minus(row, mode) for mode in study.against),
        _promised(row),
        "" if math.isnan(played.success_rate) else f"{100 * played.success_rate:.1f} %",
        *(f"{row.measured[one.name].mean:.4g}" for one in study.measures),
        f"{sum(lengths) / len(lengths):.1f}",
        f"{sum(played.seconds) / len(played.seconds):.3g} s" if played.seconds else "",
        f"{played.a_step('expansions'):,.1f}" if played.totals["expansions"] else "",
        "" if math.isnan(row.gap.mean) else f"{row.gap.mean:.4g}",
        _counts(played.searches) + ("; " + "; ".join(set(played.problems)) if played.problems else ""),
    )


def _minus(row: Row, mode: str) -> str:
    if mode not in row.differences:
        return ""
    return f"{row.differences[mode]}{', **below**' if mode in row.is_below else ''}"


def _promised(row: Row) -> str:
    if math.isnan(row.promised.mean):
        return ""
    return f"{row.promised.mean:.3f}{', more than earned' if row.promises_too_much else ''}"


def _counts(of: Counter[str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in sorted(of.items()))


def markdown(table: Table) -> str:
    """Return a table in Markdown."""
    columns = columns_of(table)
    lines = (columns, ("---",) * len(columns), *cells_of(table))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
