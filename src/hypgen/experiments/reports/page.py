# SPDX-License-Identifier: Apache-2.0
"""The page of a report: what a template shows of a folder's studies."""

from __future__ import annotations

import math
import re
import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

import jinja2
from markupsafe import Markup

from hypgen import __version__
from hypgen.experiments.published import QUANTITIES, Published
from hypgen.experiments.record import Record
from hypgen.experiments.reports import export, figures, svg, texts
from hypgen.experiments.reports.figure_file import figure_style, legend_of
from hypgen.experiments.results import Place
from hypgen.experiments.statistics import Interval
from hypgen.experiments.suite_values import ON_GPU
from hypgen.experiments.tables import Row, Table, label_of, varied_in

_TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("hypgen.experiments.reports", "."),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


@dataclass(frozen=True)
class Line:
    """A row of a table as texts; ``details`` is said of it under the pointer."""

    letter: str
    mode: str
    setting: str
    cells: dict[str, tuple[str, str, str]]  # a column's text, what stands small below, and a CSS class
    promise: Markup
    problem: str


def page_of(record: Record, studies: Sequence[Sequence[Table]]) -> str:
    """Return the page of a folder whose studies have these tables."""
    tables = [table for study in studies for table in study]
    places = _places(tables)
    began = sorted(time for table in tables for row in table.rows for time in row.played.began)
    return _TEMPLATES.get_template("page.html.j2").render(
        title=record.title,
        suite=record.suite,
        version=__version__,
        first=_day(began[0]) if began else "",
        last=_day(began[-1]) if began else "",
        machines=[(f"M{i}", place) for i, place in enumerate(places, 1)],
        gpus=sorted({place.device for table in tables for place in _gpus(table)}),
        states=[
            _state(recorded.study.name, study)
            for recorded, study in zip(record.studies, studies, strict=True)
        ],
        warnings=_warnings(tables),
        studies=[
            _study(record, study, places)
            for study in studies
            if any(row.played.returns for table in study for row in table.rows)
        ],
        data=Markup(export.as_json({"title": record.title, "rows": export.settings(tables)})),
        style=Markup(_TEMPLATES.get_template("page.css").render() + figure_style()),
    )


def _study(record: Record, tables: Sequence[Table], places: Sequence[Place]) -> dict[str, Any]:
    study = tables[0].study
    drawn: dict[str, list[dict[str, Any]]] = {}
    for task, figure in figures.figures_of(tables):
        drawn.setdefault(task, []).append(_figure(figure))
    rows = export.settings(tables)
    return {
        "name": study.name,
        "anchor": anchor(study.name),
        "command": f"hypgen bench {shlex.quote(record.suite)} --only {shlex.quote(study.name)}",
        "runs": study.runs,
        "tasks": [_table(table, places) | {"figures": drawn.get(table.task.name, [])} for table in tables],
        "figures": drawn.get("", []),
        "csv": "data:text/csv;charset=utf-8," + quote(export.as_csv(rows)),
        "file": f"{anchor(study.name)}.csv",
    }


def _figure(figure: figures.Figure) -> dict[str, Any]:
    return {
        "axis": figure.axis,
        "rows": _rows_of_panels(figure),
        "legend": [(Markup(swatch), label) for swatch, label in legend_of(figure)],
    }


def _rows_of_panels(figure: figures.Figure) -> list[list[Markup]]:
    """Return the panels side by side; divided ones have a row for each quantity."""
    rows: dict[str, list[Markup]] = {}
    for panel in figure.panels:
        key = panel.quantity if panel.about else ""
        rows.setdefault(key, []).append(Markup(svg.panel(figure, panel)))
    return list(rows.values())


def _table(table: Table, places: Sequence[Place]) -> dict[str, Any]:
    varied = varied_in(table)
    mixed = _mixed(table)
    ends = [
        value
        for row in table.rows
        for value in (row.returned.low, row.returned.high, row.returned.mean, row.promised.mean)
        if math.isfinite(value)
    ]
    low, high = (min(ends), max(ends)) if ends else (0.0, 1.0)
    low, high = (low, high) if high > low else (low - 1.0, high + 1.0)
    lines = [
        _line(row, label_of(row.setting, varied), (low, high), places if mixed else ()) for row in table.rows
    ]
    published = [one for one in figures.lettered(table.study.published) if one[1].task == table.task.name]
    lines += [_published(letter, one) for letter, one in published]
    columns = [name for name in _columns(table) if any(line.cells.get(name, ("",))[0] for line in lines)]
    return {
        "name": table.task.name,
        "model": table.task.model.name,
        "values": ", ".join(text.replace("=", " = ") for text in table.task.settings),
        "columns": [(name, _HEADINGS.get(name, name)) for name in columns],
        "lines": lines,
        "published": published,
        "mixed": mixed,
        "is_whole": table.is_whole,
    }


_HEADINGS = {
    "return": "return, 95 %", "promised": "promised and earned", "decision": "a decision",
    "expansions": "expansions a step", "searches": "how searches ended",
}  # fmt: skip


def _columns(table: Table) -> list[str]:
    """Return the columns that a table may have."""
    minus = (f"minus {mode}" for mode in table.study.against)
    measured = (one.name for one in table.study.measures)
    left = ["episodes", "return", *minus, "promised", "success", *measured, "steps", "decision", "expansions"]
    return [*left, "speed-up", "first gap", "machine", "searches"]


def _line(row: Row, label: str, ends: tuple[float, float], places: Sequence[Place]) -> Line:
    played, mode = row.played, row.setting.mode
    problem = "; ".join(dict.fromkeys(played.problems))
    if not played.returns:
        return Line("", mode, label, {"episodes": (f"0 of {played.wanted}", "", "")}, Markup(""), problem)
    missing = f"of {played.wanted}" if len(played.returns) < played.wanted else ""
    cells = {
        "episodes": (str(len(played.returns)), missing, ""),
        "return": (texts.mean_text(row.returned), texts.interval_text(row.returned), ""),
        "success": (texts.percent(row.success.mean), _percents(row.success), ""),
        "steps": (texts.number(row.steps.mean, 1), "", ""),
        "first gap": (texts.mean_text(row.gap), "", ""),
        "decision": (texts.seconds_text(_mean(played.seconds)), "", ""),
        "expansions": (texts.count_text(played.a_step("expansions") or math.nan), "", ""),
        "speed-up": (
            f"{texts.count_text(row.speed_up)}\u00d7" if math.isfinite(row.speed_up) else "",
            "",
            "",
        ),
        "searches": (_counts(played.searches), "", "words"),
        "machine": (", ".join(f"M{i}" for i, place in enumerate(places, 1) if _is_of(place, row)), "", ""),
    }
    for against, one in row.differences.items():
        interval = one.interval
        if interval.count:
            shown = "" if one.is_shown else ", not\u00a0shown"
            css = ("better" if interval.mean > 0.0 else "worse") if one.is_shown else "hidden"
            cells[f"minus {against}"] = (texts.signed(interval), texts.interval_text(interval) + shown, css)
    for name, measured in row.measured.items():
        cells[name] = (texts.mean_text(measured), texts.interval_text(measured), "")
    if math.isfinite(row.promised.mean):
        decimals = texts.mean_text(row.promised)
        note = f"{texts.signed(row.excess)} over" if row.promises_too_much else ""
        cells["promised"] = (decimals, note, "worse-note" if note else "")
    return Line(
        "", mode, label, cells, Markup(svg.promise(row.returned, row.promised.mean, *ends, mode)), problem
    )


def _published(letter: str, one: Published) -> Line:
    values = dict(one.values)
    low, high = one.interval or (math.nan, math.nan)
    returned = Interval(values.get("return", math.nan), low, high, 1)
    cells = {
        "return": (texts.mean_text(returned), texts.interval_text(returned), ""),
        "success": (texts.percent(values.get("success", math.nan)), "", ""),
        "steps": (texts.number(values.get("steps", math.nan), 1), "", ""),
        "decision": (texts.seconds_text(values.get("seconds", math.nan)), "", ""),
        "expansions": (texts.count_text(values.get("expansions", math.nan)), "", ""),
        **{name: (texts.number(value, 4), "", "") for name, value in one.values if name not in QUANTITIES},
        "speed-up": (f"{texts.count_text(values['speed_up'])}\u00d7" if "speed_up" in values else "", "", ""),
    }
    return Line(letter, one.mode or "published", one.label, cells, Markup(""), "")


def _percents(value: Interval) -> str:
    return f"{100 * value.low:.0f} to {100 * value.high:.0f} %" if value.is_known else ""


def _counts(of: Counter[str]) -> str:
    return ", ".join(f"{name} {number:,}" for name, number in sorted(of.items()))


def _state(name: str, tables: Sequence[Table]) -> dict[str, Any]:
    """Return how much of a study is played, what is missing, and what failed."""
    rows = [(table, row) for table in tables for row in table.rows]
    missing, failed = [], []
    for table, row in rows:
        label = f"{table.task.name}: {label_of(row.setting, varied_in(table))}"
        if row.played.problems:
            failed.append((label, "; ".join(dict.fromkeys(row.played.problems))))
        elif len(row.played.returns) < row.played.wanted:
            missing.append((label, len(row.played.returns), row.played.wanted))
    done = sum(min(len(row.played.returns), row.played.wanted) for _, row in rows)
    total = sum(row.played.wanted for _, row in rows)
    share = done / total if total else 1.0
    return {
        "name": name,
        "anchor": anchor(name) if done else "",
        "done": done,
        "total": total,
        "share": share,
        "missing": missing,
        "failed": failed,
    }


def _warnings(tables: Sequence[Table]) -> list[str]:
    mixed = [f"{table.study.name}, {table.task.name}" for table in tables if _mixed(table)]
    crowded = sum(row.played.crowded for table in tables for row in table.rows)
    cells = sum(row.played.places.total() for table in tables for row in table.rows)
    found = []
    if mixed:
        found.append(
            f"Some tables mix machines, compilers or versions of hypgen: {'; '.join(mixed)}. "
            "Times, and what is played within a time, do not compare there."
        )
    if crowded:
        found.append(
            f"{crowded} of {cells} cells began on a machine with more to do than it has cores: "
            "their times may be too long."
        )
    return found


def _mixed(table: Table) -> str:
    """Return what differs between the machines of a table; empty where nothing that counts does."""
    places = {place for row in table.rows for place in row.played.places}
    kinds = {
        "processors": {place.processor for place in places},
        "numbers of cores": {str(place.cores) for place in places},
        "versions of hypgen": {place.hypgen for place in places},
        "compilers": {place.compiler for place in places},
        "GPUs": {place.device for place in _gpus(table)},
    }
    return "; ".join(
        f"{name} {' and '.join(sorted(found))}" for name, found in kinds.items() if len(found) > 1
    )


def _gpus(table: Table) -> set[Place]:
    return {place for row in table.rows if row.setting.mode in ON_GPU for place in row.played.places}


def _places(tables: Sequence[Table]) -> list[Place]:
    """Return the machines, each once: a machine's devices do not tell it from itself."""
    found: dict[tuple[str, ...], Place] = {}
    for table in tables:
        for row in table.rows:
            for place in row.played.places:
                found.setdefault(_machine(place), place)
    return list(found.values())


def _machine(place: Place) -> tuple[str, ...]:
    return place.processor, str(place.cores), place.system, place.hypgen, place.compiler


def _is_of(place: Place, row: Row) -> bool:
    return any(_machine(place) == _machine(one) for one in row.played.places)


def anchor(name: str) -> str:
    """Return a name as it may stand in an address and in a file's name."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "study"


def _day(time: str) -> str:
    return time[:16].replace("T", " ")


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else math.nan
