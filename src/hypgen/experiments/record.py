# SPDX-License-Identifier: Apache-2.0
"""What a folder says of its suite: studies with the names of their cells. A report needs no other file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from hypgen.experiments.measures import Measure
from hypgen.experiments.published import Published
from hypgen.experiments.results import cells_by_setting
from hypgen.experiments.store import Named, Store
from hypgen.experiments.suite import Setting, Study, Suite, Task
from hypgen.experiments.suite_values import SuiteError


@dataclass(frozen=True)
class Name:
    """A cell of a folder, by its name alone."""

    key: str


@dataclass(frozen=True)
class Recorded:
    """A study, and the cells of its settings; a setting has none until its task is compiled once."""

    study: Study
    cells: Mapping[Setting, list[Named]]


@dataclass(frozen=True)
class Record:
    """All studies of a folder. ``suite`` is the suite's file as it was given."""

    title: str
    suite: str
    studies: tuple[Recorded, ...]


def record(suite: Suite, programs: dict[str, str], store: Store) -> None:
    """Keep a suite's studies in its folder.

    ``programs`` has the names of the generated code of tasks. A study with a task that it lacks keeps the
    cells that the folder knew of before.
    """
    known = {_without_cells(one): one for one in store.note().get("studies", [])}
    studies = []
    for study in suite.studies:
        has_all = all(setting.task.name in programs for setting in study.settings)
        new = _to_json(study, cells_by_setting(study, programs) if has_all else {})
        studies.append(new if has_all else known.get(_without_cells(new), new))
    name = suite.path.name if suite.path.is_absolute() else str(suite.path)
    store.write_note({"title": suite.title, "suite": name, "studies": studies})


def read_record(store: Store) -> Record:
    """Return what a folder says of its suite; raise ``SuiteError`` where it does not."""
    note = store.note()
    if "studies" not in note:
        raise SuiteError(
            f"'{store.folder}' does not say yet what its cells are: "
            f"`hypgen bench SUITE.toml -o {store.folder} --tables` writes that"
        )
    try:
        return Record(note["title"], note["suite"], tuple(_from_json(one) for one in note["studies"]))
    except (KeyError, TypeError, ValueError) as error:
        raise SuiteError(
            f"the suite.json of '{store.folder}' is of another version of hypgen "
            f"({type(error).__name__}: {error}): `hypgen bench SUITE.toml -o {store.folder} --tables` "
            "writes it anew"
        ) from None


def _to_json(study: Study, cells: Mapping[Setting, list[Named]]) -> dict[str, Any]:
    settings = [
        {
            "task": one.task.name,
            "labels": one.labels,
            "options": one.options,
            "seed": one.seed,
            "cells": [cell.key for cell in cells.get(one, [])],
        }
        for one in study.settings
    ]
    tasks = [
        {"name": task.name, "model": task.model.name, "settings": task.settings, "at": task.at}
        for task in dict.fromkeys(one.task for one in study.settings)
    ]
    return {
        "name": study.name,
        "runs": study.runs,
        "against": study.against,
        "episodes_a_cell": study.episodes_a_cell,
        "tasks": tasks,
        "settings": settings,
        "published": [asdict(one) for one in study.published],
        "measures": [asdict(one) for one in study.measures],
    }


def _from_json(found: Mapping[str, Any]) -> Recorded:
    tasks = {
        one["name"]: Task(
            one["name"], Path(one["model"]), settings=tuple(one["settings"]), at=_pairs(one["at"])
        )
        for one in found["tasks"]
    }
    cells = {
        Setting(tasks[one["task"]], _pairs(one["labels"]), _pairs(one["options"]), one["seed"]): [
            Name(key) for key in one["cells"]
        ]
        for one in found["settings"]
    }
    published = tuple(
        Published(
            one["task"],
            one["label"],
            one["source"],
            one["differs"],
            one["mode"],
            _pairs(one["at"]),
            _pairs(one["values"]),
            None if one["interval"] is None else (one["interval"][0], one["interval"][1]),
        )
        for one in found["published"]
    )
    study = Study(
        found["name"],
        tuple(cells),
        found["runs"],
        tuple(found["against"]),
        found["episodes_a_cell"],
        published,
        tuple(Measure(**one) for one in found["measures"]),
    )
    return Recorded(study, {setting: list[Named](names) for setting, names in cells.items()})


def _pairs(found: list[list[Any]]) -> tuple[tuple[str, Any], ...]:
    return tuple((name, value) for name, value in found)


def _without_cells(study: Mapping[str, Any]) -> str:
    """Return a study's text but for its cells: that of an unchanged study stays."""
    settings = [{**one, "cells": []} for one in study["settings"]]
    return json.dumps({**study, "settings": settings}, sort_keys=True)
