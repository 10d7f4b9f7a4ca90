# SPDX-License-Identifier: Apache-2.0
"""A report's numbers as data: a row for each setting, or for each episode."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from hypgen.experiments.published import Published
from hypgen.experiments.statistics import Difference, Interval
from hypgen.experiments.tables import Row, Table, label_of, varied_in


def settings(tables: Sequence[Table]) -> list[dict[str, Any]]:
    """Return a row for each setting of some tables, and for each published value; None is unknown."""
    return [row for table in tables for row in _of_table(table)]


def _of_table(table: Table) -> Iterator[dict[str, Any]]:
    varied = varied_in(table)
    for row in table.rows:
        yield {"study": table.study.name, "task": table.task.name, "kind": "played"} | _of_row(
            row, table, varied
        )
    for one in table.study.published:
        if one.task == table.task.name:
            yield {"study": table.study.name, "task": one.task, "kind": "published"} | _of_published(one)


def _of_row(row: Row, table: Table, varied: set[str]) -> dict[str, Any]:
    played = row.played
    options = {f"option.{name}": value for name, value in row.setting.options if name != "mode"}
    return {
        "setting": label_of(row.setting, varied),
        "mode": row.setting.mode,
        **options,
        "episodes": len(played.returns),
        "episodes_asked": played.wanted,
        **_interval("return", row.returned),
        "promised": _known(row.promised.mean),
        **_interval("promised_minus_earned", row.excess),
        **{name: value for mode, one in row.differences.items() for name, value in _difference(mode, one)},
        **_interval("success", row.success),
        **{key: value for name, one in row.measured.items() for key, value in _interval(name, one).items()},
        **_interval("steps", row.steps),
        "decision_seconds": _known(_mean(played.seconds)),
        "update_seconds": _known(_mean(played.updates)),
        **{f"{name}_a_step": _known(played.a_step(name)) for name in ("expansions", "nodes", "trials")},
        **_interval("first_gap", row.gap),
        "collisions_a_step": _known(played.a_step("collisions")),
        "trials_a_second": _known(played.a_second("trials")),
        "depth": _known(played.a_step("max_depth")),
        "expansions_a_second": _known(played.a_second("expansions")),
        "speed_up": _known(row.speed_up),
        "processors": "; ".join(sorted({place.processor for place in played.places})),
        "problems": "; ".join(dict.fromkeys(played.problems)),
    }


def _of_published(one: Published) -> dict[str, Any]:
    names = {"seconds": "decision_seconds", "expansions": "expansions_a_step"}
    return {
        "setting": one.label,
        "mode": one.mode,
        **{f"option.{name}": value for name, value in one.at},
        **{names.get(name, name): value for name, value in one.values},
        "return_low": one.interval[0] if one.interval else None,
        "return_high": one.interval[1] if one.interval else None,
        "source": one.source,
        "differs": one.differs,
    }


def episodes(tables: Sequence[Table]) -> list[dict[str, Any]]:
    """Return a row for each episode of some tables."""
    return [
        {
            "study": table.study.name,
            "task": table.task.name,
            "setting": str(row.setting),
            "mode": row.setting.mode,
            **{f"option.{name}": value for name, value in row.setting.options if name != "mode"},
            "seed": row.setting.seed,
            "episode": episode,
            "discounted_return": earned,
            "promised": row.played.promised.get(episode),
            "steps": row.played.lengths[episode],
            "success": row.played.successes.get(episode),
            **{name: values[episode] for name, values in row.played.measured.items()},
        }
        for table in tables
        for row in table.rows
        for episode, earned in sorted(row.played.returns.items())
    ]


def as_csv(rows: Sequence[dict[str, Any]]) -> str:
    """Return rows as CSV with the columns of all of them."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def as_json(value: Any) -> str:
    """Return JSON that may stand within a page: no text in it can end its element."""
    return json.dumps(value, allow_nan=False).replace("<", "\\u003c")


def write_parquet(rows: Sequence[dict[str, Any]], file: Path) -> None:
    """Write rows as Parquet; raise ``ModuleNotFoundError`` where polars is not installed."""
    import polars

    found = {name: _of_one_type([row.get(name) for row in rows]) for name in columns(rows)}
    polars.DataFrame(found).write_parquet(file)


def _of_one_type(values: list[Any]) -> list[Any]:
    """Return a column as numbers where all are numbers, and as texts where they are of several types."""
    types = {type(value) for value in values if value is not None}
    if len(types) <= 1:
        return values
    as_one: type[float] | type[str] = float if types == {int, float} else str
    return [None if value is None else as_one(value) for value in values]


def columns(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return the names of all columns, in the order in which rows first have them."""
    return list(dict.fromkeys(name for row in rows for name in row))


def _difference(mode: str, one: Difference) -> Iterator[tuple[str, Any]]:
    name = f"minus_{mode}"
    yield from _interval(name, one.interval).items()
    yield f"{name}_pairs", one.interval.count
    yield f"{name}_p", _known(one.p)
    yield f"{name}_shown", one.is_shown


def _interval(name: str, value: Interval) -> dict[str, float | None]:
    low, high = _known(value.low), _known(value.high)
    return {name: _known(value.mean), f"{name}_low": low, f"{name}_high": high}


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else math.nan
