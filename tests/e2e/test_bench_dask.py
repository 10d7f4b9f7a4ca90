# SPDX-License-Identifier: Apache-2.0
"""A suite on workers of Dask: with one killed, a cell that fails, and nobody to play it."""

import json
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("distributed")  # of the extra [dask]

from distributed import LocalCluster
from support import clusters
from support.clusters import SUITE

import hypgen
from hypgen.cli import main
from hypgen.cli.exit_codes import Exit
from hypgen.experiments import cluster as module
from hypgen.experiments import worker
from hypgen.experiments.cells import Cell, cells_of
from hypgen.experiments.cluster import DaskExecutor
from hypgen.experiments.running import State
from hypgen.experiments.store import Store
from hypgen.experiments.suite import read_suite
from hypgen.experiments.suite_values import SuiteError


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    with clusters.workers(2) as made:
        yield made


@pytest.fixture(scope="module")
def scheduler() -> Iterator[LocalCluster]:
    """A scheduler without workers."""
    with LocalCluster(n_workers=0, processes=False, dashboard_address=":0", protocol="tcp") as made:
        yield made


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    path = tmp_path / "tigers.toml"
    path.write_text(SUITE)
    return path


def a_cell(suite: Path, mode: str) -> Cell:
    setting = next(one for one in read_suite(suite).studies[0].settings if one.mode == mode)
    return Cell(setting, "0" * 16, 0, 2)


@pytest.mark.cxx
def test_a_suite_that_loses_a_worker_ends_with_the_table_of_this_machine(
    suite: Path, tmp_path: Path, cluster: LocalCluster
) -> None:
    here = clusters.texts(hypgen.bench(suite, tmp_path / "here", jobs=2))
    failures = []

    def tell(state: State) -> None:
        failures[:] = state.failures
        if state.done == 2:
            clusters.kill_a_busy_worker(cluster)

    assert clusters.play(suite, tmp_path / "there", cluster, tell) == here
    assert not failures
    names = [sorted(path.name for path in (tmp_path / at).iterdir()) for at in ("here", "there")]
    assert names[0] == names[1]
    cell = next((tmp_path / "there").glob("*.jsonl"))
    cell.unlink()
    asked = ["bench", str(suite), "-o", str(tmp_path / "there"), "--dask", cluster.scheduler_address]
    assert main.run(asked) == Exit.OK
    head = json.loads(cell.read_text().splitlines()[0])
    assert head["worker"].startswith("tcp://") and head["compiler"] and head["machine"]["processor"]


@pytest.mark.cxx
def test_a_setting_that_fails_is_left_out_and_the_end_of_the_play_ends_its_solvers(
    suite: Path, tmp_path: Path, cluster: LocalCluster
) -> None:
    long = 'play = ["default", { mode = "rollout", xi = 7.0, trials = 5 }, { mode = "despot", time = 100.0 }]'
    suite.write_text(SUITE.replace('play = ["despot"]', long).replace("trials = [5, 20]\n", ""))
    executor = DaskExecutor(cluster.scheduler_address)
    states = []

    def tell(state: State) -> None:
        states.append(state)
        if state.failures:
            clusters.wait(clusters.solvers)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hypgen.bench(suite, tmp_path / "out", executor=executor, tell=tell)
    executor.close()
    assert "the solver ended with code" in states[-1].failures[0].problem
    clusters.wait(lambda: not clusters.solvers())
    assert len(list((tmp_path / "out").glob("*.failed"))) == 1


def test_a_worker_with_another_runtime_refuses_a_cell(cluster: LocalCluster) -> None:
    work = worker.Work("0" * 16, worker.pack({"src/main.cpp": ""}), (), None, 1, False, 10.0, "0.0")
    with cluster.get_client() as client:
        played = client.submit(worker.play, work).result()
    assert "its hypgen" in played.problem and "has another runtime than the client's 0.0" in played.problem


def test_cells_that_no_worker_can_play_are_told(
    suite: Path, tmp_path: Path, cluster: LocalCluster, scheduler: LocalCluster
) -> None:
    suite.write_text(SUITE.replace('["despot"]', '["gpu"]'))
    for of, says in ((cluster, '--resources "CORES=1 GPU=1"'), (scheduler, "has no workers")):
        executor = DaskExecutor(of.scheduler_address, patience=0.0)
        with pytest.raises(SuiteError, match=says):
            list(executor.play([a_cell(suite, "gpu")], Store(tmp_path)))
        executor.close()


def test_cells_for_a_gpu_do_not_keep_others_from_playing(suite: Path) -> None:
    suite.write_text(SUITE.replace('["despot"]', '[{ mode = "hyp", threads = 8 }, "gpu"]'))
    cells = cells_of(read_suite(suite).studies, {"tiger": "0" * 16})
    small, large = ({"nthreads": 1, "resources": {"CORES": 4.0} | gpu} for gpu in ({}, {"GPU": 1.0}))
    sent = module._next(cells, [], [small, large])
    assert [cell.setting.mode for cell, _ in sent] == [
        "hyp",
        "hyp",
        "default",
        "rollout",
        "rollout",
        "default",
    ]
    assert sent[0][1] == {"CORES": 4.0, "GPU": 1.0} and sent[2][1] == {"CORES": 1.0}
    assert not module._next(cells, [cell for cell, _ in sent], [small, large])
    assert module._next(cells[:1], [], [{"nthreads": 1, "resources": {"GPU": 1.0}}])[0][1] == {"GPU": 1.0}
    assert not module._next(cells[:1], [], [small]) and not module._next(cells, [], [])


def test_a_scheduler_that_is_lost_is_told(suite: Path, tmp_path: Path, scheduler: LocalCluster) -> None:
    executor = DaskExecutor(scheduler.scheduler_address)
    threading.Timer(0.1, executor.close).start()  # as Dask's client does where it cannot connect again
    with pytest.raises(SuiteError, match="the Dask scheduler is lost"):
        list(executor.play([a_cell(suite, "default")], Store(tmp_path)))


def test_a_scheduler_that_does_not_answer_is_told(
    suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "REACH", 0.2)
    asked = ["bench", str(suite), "-o", str(tmp_path / "out"), "--dask"]
    for address in ("tcp://127.0.0.1:1", "no such address", "http://127.0.0.1:80"):
        assert main.run([*asked, address]) == Exit.MISTAKE
        assert f"no Dask scheduler answers at '{address}'" in capfd.readouterr().err
    assert main.run([*asked, "tcp://127.0.0.1:1", "--jobs", "2"]) == Exit.MISTAKE


def test_missing_dask_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SuiteError, match=r"pip install 'hypgen\[dask\]'"):
        DaskExecutor("tcp://127.0.0.1:1")
