# SPDX-License-Identifier: Apache-2.0
import shutil
from pathlib import Path

import pytest
from support import synthetic_cells

from hypgen.experiments.record import read_record, record
from hypgen.experiments.store import Store
from hypgen.experiments.suite import read_suite
from hypgen.experiments.suite_values import SuiteError

SUITE = """
title = "T"
[tasks.rocks]
model = "rocks.pomdp"
set = { size = 7 }
at = { actions = 12 }
[tasks.tag]
model = "tag.pomdp"
[[study]]
name = "rocks"
tasks = ["rocks"]
runs = 7
time = [1, 2.5]
pruning = 0.1
[[study.published]]
task = "rocks"
label = "DESPOT"
return = 20.9
interval = 0.3
source = "a paper"
differs = "the machine"
[[study]]
name = "tag"
tasks = ["tag"]
runs = 5
trials = 9
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return synthetic_cells.write_suite(tmp_path, SUITE)


def test_a_folder_that_has_moved_says_what_its_cells_are(path: Path, tmp_path: Path) -> None:
    synthetic_cells.play(path, tmp_path / "out")
    shutil.move(tmp_path / "out", tmp_path / "elsewhere")
    for file in (path, tmp_path / "rocks.pomdp", tmp_path / "tag.pomdp"):
        file.unlink()
    store = Store(tmp_path / "elsewhere")
    found = read_record(store)
    assert (found.title, found.suite) == ("T", "suite.toml")
    [rocks, tag] = found.studies
    assert [str(one) for one in rocks.study.settings][-1] == "rocks, despot time 2.5 pruning 0.1"
    assert rocks.study.settings[0].task.at == (("actions", 12),)
    assert rocks.study.published[0].interval == pytest.approx((20.6, 21.2))
    assert {len(cells) for cells in rocks.cells.values()} == {2}
    assert all(store.has(cell) for one in (rocks, tag) for cells in one.cells.values() for cell in cells)


def test_a_study_that_is_not_compiled_now_keeps_its_cells(path: Path, tmp_path: Path) -> None:
    suite, store = read_suite(path), Store(tmp_path / "out")
    store.open("T")
    record(suite, {"rocks": "abc"}, store)
    [rocks, tag] = read_record(store).studies
    assert all(rocks.cells.values()) and not any(tag.cells.values())
    record(suite, {"tag": "abc"}, store)
    assert read_record(store).studies[0] == rocks, "as it was"
    path.write_text(SUITE.replace("runs = 7", "runs = 8"))
    record(read_suite(path), {"tag": "abc"}, store)
    assert not any(read_record(store).studies[0].cells.values()), "it is another study now"


@pytest.mark.parametrize(
    ("note", "says"),
    [
        (None, "is no folder of a suite: it has no suite.json"),
        ("{", "suite.json' cannot be read"),
        ("[1]", "is not what `hypgen bench` writes"),
        ('{"title": "T"}', "does not say yet what its cells are"),
        ('{"title": "T", "suite": "t.toml", "studies": [{}]}', "is of another version of hypgen"),
    ],
)
def test_what_is_no_folder_of_a_suite_is_said(tmp_path: Path, note: str | None, says: str) -> None:
    if note is not None:
        (tmp_path / "suite.json").write_text(note)
    with pytest.raises(SuiteError) as error:
        read_record(Store(tmp_path))
    assert says in str(error.value)
    assert note == "{" or "hypgen bench" in str(error.value)
