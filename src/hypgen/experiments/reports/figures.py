# SPDX-License-Identifier: Apache-2.0
"""Which figures a study gets, as data: what varies in it decides."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from hypgen.experiments.published import Published
from hypgen.experiments.reports.texts import count_text
from hypgen.experiments.statistics import Interval
from hypgen.experiments.suite import Setting, Task, Value
from hypgen.experiments.suite_values import MODES
from hypgen.experiments.tables import Row, Table, label_of, varied_in

MOST_SERIES = 7  # in one figure; more are divided by an option
_DECADE = 10.0  # an axis whose values span more is logarithmic


@dataclass(frozen=True)
class Point:
    """A value at a place of the axis. ``text`` is said of it; ``note`` stands beside it."""

    x: float
    y: Interval
    text: str
    note: str = ""


@dataclass(frozen=True)
class Series:
    """Points of one line. ``variant`` counts the lines of a mode; a level holds along the whole axis."""

    label: str
    mode: str
    variant: int
    points: tuple[Point, ...]
    is_level: bool = False


@dataclass(frozen=True)
class Mark:
    """A published value; ``letter`` names it in legend and table."""

    letter: str
    label: str
    mode: str
    point: Point


@dataclass(frozen=True)
class Panel:
    """One quantity of a figure; ``about`` has the options that all its points share, where others do not."""

    quantity: str
    about: str
    series: tuple[Series, ...]
    marks: tuple[Mark, ...]
    is_log: bool


@dataclass(frozen=True)
class Figure:
    """Curves along an axis, or dots of single settings where ``axis`` is empty; one legend for all panels."""

    axis: str
    is_log: bool
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class Quantity:
    """What a panel shows of a row, and of published values."""

    name: str
    of: Callable[[Row], Interval]
    published: str = ""
    can_be_log: bool = False


def _exactly(value: float) -> Interval:
    return Interval(value, math.nan, math.nan, 1 if math.isfinite(value) else 0)


def _count(name: str) -> Callable[[Row], Interval]:
    """Return a count's mean over steps; a setting without a search has none."""
    return lambda row: _exactly(row.played.a_step(name) or math.nan)


RETURN = Quantity("return", lambda row: row.returned, "return")
SUCCESS = Quantity("success rate", lambda row: row.success, "success")
EXPANSIONS = Quantity("expansions a step", _count("expansions"), "expansions", can_be_log=True)
NODES = Quantity("tree size, nodes", _count("nodes"), can_be_log=True)
DEPTH = Quantity("depth of the tree", _count("max_depth"))
SPEED_UP = Quantity(
    "speed-up against despot", lambda row: _exactly(row.speed_up), "speed_up", can_be_log=True
)

_OF_CURVES = (RETURN, SUCCESS, NODES, DEPTH)
_OF_DOTS = (RETURN, SUCCESS, EXPANSIONS)
_OF_TASKS = (RETURN, SUCCESS, NODES, SPEED_UP)

Place = tuple[str, Callable[[Row], Value | None], Callable[[Published], Value | None]]


def spans_decades(values: Iterable[float]) -> bool:
    """Return whether values are better read on a logarithmic axis."""
    found = [value for value in values if math.isfinite(value)]
    return bool(found) and min(found) > 0.0 and max(found) / min(found) > _DECADE


def axes_of(rows: Sequence[Row]) -> list[str]:
    """Return the options with numbers that differ between two settings of one mode that have one other."""
    names = dict.fromkeys(name for row in rows for name, value in row.setting.labels if _is_number(value))
    return [name for name in names if any(_differ_in(name, a.setting, b.setting) for a in rows for b in rows)]


def _differ_in(name: str, one: Setting, other: Setting) -> bool:
    ours, theirs = dict(one.labels), dict(other.labels)
    told = name in dict(one.options) and name in dict(other.options)
    return told and ours.pop(name, None) != theirs.pop(name, None) and ours == theirs


def task_axis(tasks: Sequence[Task]) -> tuple[str, dict[Task, float]] | None:
    """Return the number that tells tasks apart: the first of their ``at``, or the only value that differs."""
    places = _distinct({task: dict(task.at) for task in tasks})
    if not places:
        values = _distinct({task: _numbers(task) for task in tasks})
        places = values if len(values) == 1 else {}
    return next(iter(places.items()), None)


def _distinct(numbers: dict[Task, dict[str, float]]) -> dict[str, dict[Task, float]]:
    """Return the names whose numbers all tasks have, each another; one task has nothing to tell apart."""
    names = dict.fromkeys(name for found in numbers.values() for name in found)
    common = [name for name in names if all(name in found for found in numbers.values())]
    places = {name: {task: found[name] for task, found in numbers.items()} for name in common}
    return {name: at for name, at in places.items() if len(set(at.values())) == len(numbers) > 1}


def _numbers(task: Task) -> dict[str, float]:
    found = {}
    for setting in task.settings:
        name, _, text = setting.partition("=")
        try:
            found[name] = float(text)
        except ValueError:
            continue
    return found


def lettered(published: Sequence[Published]) -> list[tuple[str, Published]]:
    """Return published values with the letters that name them: A to Z, then AA and so on."""
    return [(_letters(i), one) for i, one in enumerate(published)]


def _letters(number: int) -> str:
    return (_letters(number // 26 - 1) if number >= 26 else "") + chr(ord("A") + number % 26)


def figures_of(tables: Sequence[Table]) -> list[tuple[str, Figure]]:
    """Return the figures of a study, each with the name of its task, which is empty for several tasks."""
    found = [(table.task.name, figure) for table in tables for figure in _of_table(table)]
    axis = task_axis([table.task for table in tables])
    if axis is not None:
        name, places = axis
        rows = [row for table in tables for row in table.rows]
        by_name = {task.name: value for task, value in places.items()}
        place: Place = (name, lambda row: places[row.setting.task], lambda one: by_name.get(one.task))
        letters = lettered(tables[0].study.published)
        found += [("", figure) for figure in _along(place, rows, letters, _OF_TASKS)]
    return found


def _of_table(table: Table) -> list[Figure]:
    rows = [row for row in table.rows if row.played.returns]
    letters = [one for one in lettered(table.study.published) if one[1].task == table.task.name]
    if not rows:
        return []
    axes = axes_of(rows)
    if not axes:
        return _dots(table, rows, letters)
    return [figure for axis in axes for figure in _along(_option(axis), rows, letters, _OF_CURVES)]


def _option(name: str) -> Place:
    def of(row: Row) -> Value | None:
        return dict(row.setting.labels).get(name) if name in dict(row.setting.options) else None

    return name, of, lambda one: dict(one.at).get(name)


def _dots(table: Table, rows: Sequence[Row], letters: Sequence[tuple[str, Published]]) -> list[Figure]:
    """Return the dots of settings that no axis orders: a line each."""
    varied, panels = varied_in(table), []
    for quantity in _OF_DOTS:
        series = tuple(
            Series(label_of(row.setting, varied), row.setting.mode, 0, (_dot(quantity, row),))
            for row in rows
            if quantity.of(row).count
        )
        if series:
            panels.append(_panel(quantity, series, _marks(quantity, letters, lambda one: 0.0)))
    return [Figure("", False, tuple(panels))]


def _dot(quantity: Quantity, row: Row) -> Point:
    faster = quantity is EXPANSIONS and math.isfinite(row.speed_up)
    note = f"{count_text(row.speed_up)}\u00d7 despot" if faster else ""
    return Point(0.0, quantity.of(row), _said(quantity, row), note)


def _along(
    place: Place,
    rows: Sequence[Row],
    letters: Sequence[tuple[str, Published]],
    quantities: Sequence[Quantity],
) -> list[Figure]:
    """Return the curves of rows along an axis: no figure, or one.

    Where these are too many lines for a panel, each value of the other options has its own panels, of what
    is earned alone.
    """
    axis, of, published = place
    parts = _divided([row for row in rows if row.played.returns], axis)
    panels = []
    for quantity in quantities if len(parts) == 1 else (RETURN, SUCCESS):
        for about, part in parts:
            lines = tuple(
                line for group in _groups(part, axis, of) if (line := _line(quantity, group)).points
            )
            marked = [(letter, one) for letter, one in letters if _belongs(one, part, axis)]
            if any(len(line.points) > 1 for line in lines):
                panels.append(_panel(quantity, lines, _marks(quantity, marked, published), about))
    lines_of_all = (line for panel in panels for line in panel.series if not line.is_level)
    places = [point.x for line in lines_of_all for point in line.points]
    return [Figure(axis, spans_decades(places), tuple(panels))] if panels else []


@dataclass(frozen=True)
class _Group:
    label: str
    mode: str
    variant: int
    rows: tuple[tuple[float, Row], ...]
    is_level: bool


def _divided(rows: Sequence[Row], axis: str) -> list[tuple[str, list[Row]]]:
    """Return rows by values of the options but ``axis``, if all in one figure are too many lines."""
    names = [name for name in _varied_within_modes(rows) if name != axis]
    keys = dict.fromkeys((row.setting.mode, _values(row, names)) for row in rows)
    if len(keys) <= MOST_SERIES or not names:
        return [("", list(rows))]
    combinations = dict.fromkeys(values for _, values in keys if len(values) == len(names))
    return [
        (
            ", ".join(f"{name} {value}" for name, value in wanted),
            [row for row in rows if set(_values(row, names)) <= set(wanted)],
        )
        for wanted in combinations
    ]


def _varied_within_modes(rows: Sequence[Row]) -> list[str]:
    """Return the options that take several values within some mode."""
    seen: dict[tuple[str, str], set[Value]] = {}
    for row in rows:
        for name, value in _told(row):
            seen.setdefault((row.setting.mode, name), set()).add(value)
    return list(dict.fromkeys(name for (_, name), values in seen.items() if len(values) > 1))


def _told(row: Row) -> list[tuple[str, Value]]:
    told = dict(row.setting.options)
    return [(name, value) for name, value in row.setting.labels if name in told and name != "mode"]


def _values(row: Row, names: Sequence[str]) -> tuple[tuple[str, Value], ...]:
    return tuple((name, value) for name, value in _told(row) if name in names)


def _groups(rows: Sequence[Row], axis: str, of: Callable[[Row], Value | None]) -> list[_Group]:
    """Return the lines: rows that differ in the axis alone."""
    names = [name for name in _varied_within_modes(rows) if name != axis]
    groups: dict[tuple[str, tuple[tuple[str, Value], ...]], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.setting.mode, _values(row, names)), []).append(row)
    found, variants = [], dict.fromkeys(MODES, 0)
    for (mode, values), members in groups.items():
        label = ", ".join([mode, *(f"{name} {value}" for name, value in values)])
        placed = [(float(x), row) for row in members if (x := of(row)) is not None and _is_number(x)]
        is_level = not placed
        points = [(0.0, row) for row in members[:1]] if is_level else sorted(placed, key=lambda one: one[0])
        found.append(_Group(label, mode, variants[mode], tuple(points), is_level))
        variants[mode] += 1
    return found


def _line(quantity: Quantity, group: _Group) -> Series:
    points = tuple(
        Point(x, value, _said(quantity, row))
        for x, row in group.rows
        if (value := quantity.of(row)).count and math.isfinite(value.mean)
    )
    return Series(group.label, group.mode, group.variant, points, group.is_level)


def _belongs(one: Published, rows: Sequence[Row], axis: str) -> bool:
    """Return whether a published value has no option that all these rows have otherwise."""
    at = {name: value for name, value in one.at if name != axis}
    return any(
        all(dict(row.setting.labels).get(name, value) == value for name, value in at.items()) for row in rows
    )


def _marks(
    quantity: Quantity,
    letters: Sequence[tuple[str, Published]],
    place: Callable[[Published], Value | None],
) -> tuple[Mark, ...]:
    found = []
    for letter, one in letters:
        value, x = dict(one.values).get(quantity.published), place(one)
        if value is None or x is None:
            continue
        low, high = (one.interval if quantity is RETURN else None) or (math.nan, math.nan)
        text = f"{letter}: {one.label}, {quantity.name} {value:g} ({one.source})"
        found.append(Mark(letter, one.label, one.mode, Point(float(x), Interval(value, low, high, 1), text)))
    return tuple(found)


def _panel(quantity: Quantity, series: tuple[Series, ...], marks: tuple[Mark, ...], about: str = "") -> Panel:
    values = [point.y.mean for line in series for point in line.points] + [
        mark.point.y.mean for mark in marks
    ]
    return Panel(quantity.name, about, series, marks, quantity.can_be_log and spans_decades(values))


def _said(quantity: Quantity, row: Row) -> str:
    value = quantity.of(row)
    interval = f" ({value.low:.4g} .. {value.high:.4g})" if value.is_known else ""
    return f"{row.setting}: {quantity.name} {value.mean:.4g}{interval}, {len(row.played.returns)} episodes"


def _is_number(value: Value | None) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
