# SPDX-License-Identifier: Apache-2.0
import functools
import json
from pathlib import Path
from typing import Any

import layouts
import pytest
from support.paths import ROOT

from hypgen.dsl import ir
from hypgen.dsl.load import load
from hypgen.dsl.types import size_of
from hypgen.experiments.suite import Task, read_suite

SUITES = sorted((ROOT / "benchmarks").glob("*.toml"))


def loaded(task: Task) -> ir.Model:
    """Return a task's model; suites share most of them."""
    return _load(task.model.resolve(), task.instance, task.settings)


@functools.cache
def _load(model: Path, instance: Path | None, settings: tuple[str, ...]) -> ir.Model:
    return load(model, instance=instance, settings=list(settings)).model


@pytest.mark.parametrize("path", SUITES, ids=lambda path: path.stem)
def test_a_committed_suite_can_be_read_with_its_models(path: Path) -> None:
    suite = read_suite(path)
    tasks = {setting.task for study in suite.studies for setting in study.settings}
    for task in tasks:
        model = loaded(task)
        if task.param is not None:
            shapes = {one.name: [size_of(t) for t in one.indices] for one in model.params}
            for layout in json.loads(task.param.read_text(encoding="utf-8")):
                assert {name: shape(values) for name, values in layout.items()}.items() <= shapes.items()
        for study in suite.studies:
            if any(setting.task == task for setting in study.settings):
                for measure in study.measures:
                    measure.check(model, study.name)


def shape(values: Any) -> list[int]:
    return [len(values), *shape(values[0])] if isinstance(values, list) else []


@pytest.mark.parametrize("name", layouts.FILES)
def test_committed_layouts_are_what_their_script_draws(name: str) -> None:
    assert (layouts.FOLDER / name).read_text(encoding="utf-8") == layouts.text_of(name)
