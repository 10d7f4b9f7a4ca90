# SPDX-License-Identifier: Apache-2.0
"""In which order cells play on a machine, with shell scripts for solvers."""

import re
import time
from pathlib import Path

import pytest

from hypgen.experiments.cells import Cell, cells_of
from hypgen.experiments.local import LocalExecutor, Running
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import read_suite

SUITE = """
[tasks.t]
model = "t.pomdp"
[[study]]
name = "s"
runs = 3
episodes_a_cell = 1
beside = false
against = "despot"
play = ["despot", "pomcp", { mode = "parallel", threads = 2 }]
trials = 1
"""
# Notes when it begins, does what a file says, waits a moment, and writes a line.
SOLVER = """#!/bin/sh
echo "$@" >> {log}
case $* in *mode=pomcp*) . {faults};; esac
sleep 0.0$(($$ % 5))
for word; do case $word in --json=*) echo '{{"type": "run"}}' > "${{word#--json=}}";; esac; done
"""


@pytest.fixture
def executor(tmp_path: Path) -> LocalExecutor:
    (tmp_path / "t.pomdp").touch()
    (tmp_path / "suite.toml").write_text(SUITE)
    solver = tmp_path / "solver"
    solver.write_text(SOLVER.format(log=tmp_path / "log", faults=tmp_path / "faults"))
    (tmp_path / "faults").touch()
    solver.chmod(0o755)
    return LocalExecutor({"t": solver}, 2, [], 60.0)


def test_no_cell_of_a_later_wave_overtakes_one_with_many_cores(
    executor: LocalExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    executor.size, executor.cores = 2, executor.cores[:1] * 2
    waves: list[int] = []
    start = executor._start

    def noted(cell: Cell, folder: Path) -> Running:
        waves.append(cell.wave)
        return start(cell, folder)

    monkeypatch.setattr(executor, "_start", noted)
    store = Store(tmp_path / "out")
    store.open("T")
    cells = cells_of(read_suite(tmp_path / "suite.toml").studies, {"t": "abc"})
    assert {one.key for one in executor.play(cells, store) if not isinstance(one, Failure)} == {
        cell.key for cell in cells
    }
    assert waves == sorted(waves) and len(waves) == 9
    assert sorted(path.suffix for path in store.folder.iterdir()) == [".json", *[".jsonl"] * 9]


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ("exec sleep 100", "the solver was killed after 1 s: out of memory, or hung"),
        ("kill -KILL $$", "the solver was killed after 1 s: out of memory, or hung"),
        ("kill -SEGV $$", "the solver was ended by signal 11"),
        ("echo no such luck >&2; exit 3", "the solver ended with code 3: no such luck"),
    ],
)
def test_a_cell_that_fails_is_kept_and_told_and_the_rest_goes_on(
    executor: LocalExecutor, tmp_path: Path, fault: str, says: str
) -> None:
    (tmp_path / "faults").write_text(fault)
    executor.cell_seconds = 1.0 if "sleep" in fault else 60.0
    store = Store(tmp_path / "out")
    store.open("T")
    cells = cells_of(read_suite(tmp_path / "suite.toml").studies, {"t": "abc"})
    outcomes = list(executor.play(cells, store))
    failures = [one for one in outcomes if isinstance(one, Failure)]
    assert {re.sub("after [0-9] s", "after 1 s", one.problem) for one in failures} == {says}
    assert {one.cell.setting.mode for one in failures} == {"pomcp"}
    assert all(store.failure(one.cell) == one.problem for one in failures)
    assert len(outcomes) - len(failures) == 6, "all of the other modes"
    assert not list(store.folder.glob("lines-*"))


def test_what_plays_at_the_end_is_ended_and_dropped(executor: LocalExecutor, tmp_path: Path) -> None:
    (tmp_path / "faults").write_text("exec sleep 100")
    store = Store(tmp_path / "out")
    store.open("T")
    cells = cells_of(read_suite(tmp_path / "suite.toml").studies, {"t": "abc"})
    began = time.monotonic()
    outcomes = list(executor.play(cells, store, began + 0.5))
    assert time.monotonic() - began < 5.0
    assert all(not isinstance(one, Failure) for one in outcomes)
    assert not list(store.folder.glob("lines-*")) and not list(store.folder.glob("*.failed"))
