# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import layouts
import pytest
from support.paths import ROOT

from hypgen.dsl.load import load
from hypgen.experiments.suite import read_suite

SUITES = sorted((ROOT / "benchmarks").glob("*.toml"))


@pytest.mark.parametrize("path", SUITES, ids=lambda path: path.stem)
def test_a_committed_suite_can_be_read_with_its_models(path: Path) -> None:
    suite = read_suite(path)
    tasks = {setting.task for study in suite.studies for setting in study.settings}
    for task in tasks:
        model = load(task.model, instance=task.instance, settings=list(task.settings)).model
        for study in suite.studies:
            if any(setting.task == task for setting in study.settings):
                for measure in study.measures:
                    measure.check(model, study.name)


@pytest.mark.parametrize("name", layouts.FILES)
def test_committed_layouts_are_what_their_script_draws(name: str) -> None:
    assert (layouts.FOLDER / name).read_text(encoding="utf-8") == layouts.text_of(name)
