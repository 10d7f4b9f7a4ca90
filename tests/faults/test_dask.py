# SPDX-License-Identifier: Apache-2.0
"""Suites on workers of Dask that die many times, all at once, or with their scheduler."""

import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("distributed")  # of the extra [dask]

import dask
from distributed import LocalCluster
from support import clusters
from support.clusters import SUITE

import hypgen
from hypgen.experiments.cells import Cell
from hypgen.experiments.cluster import DaskExecutor
from hypgen.experiments.running import State
from hypgen.experiments.store import Store
from hypgen.experiments.suite import read_suite
from hypgen.experiments.suite_values import SuiteError

pytestmark = pytest.mark.faults


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    path = tmp_path / "tigers.toml"
    path.write_text(SUITE.replace("runs = 6", "runs = 40"))
    return path


def test_a_suite_whose_workers_die_again_and_again_ends_with_the_same_table(
    suite: Path, tmp_path: Path
) -> None:
    here = clusters.texts(hypgen.bench(suite, tmp_path / "here", jobs=2))
    killed = set()

    def tell(state: State) -> None:
        if state.done // 8 not in killed:
            killed.add(state.done // 8)
            clusters.kill_a_busy_worker(cluster)

    # A cell that waits for a worker that dies counts as one that its worker died of.
    with dask.config.set({"distributed.scheduler.allowed-failures": 20}), clusters.workers(3) as cluster:
        assert clusters.play(suite, tmp_path / "there", cluster, tell) == here
    assert len(killed) > 10


def test_a_cell_that_its_workers_die_of_fails(suite: Path, tmp_path: Path) -> None:
    suite.write_text(
        SUITE.replace(
            '"despot"]\ntrials = [5, 20]', '"default", { mode = "despot", time = 100.0 }]\nbeside = false'
        )
    )
    killed = threading.Event()

    def kill() -> None:
        clusters.wait(clusters.solvers, 120.0)
        clusters.wait(lambda: any("--time=100.0" in one.cmdline() for one in clusters.solvers()), 120.0)
        clusters.kill_a_busy_worker(cluster)
        killed.set()

    failures = []

    def tell(state: State) -> None:
        failures[:] = state.failures

    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), clusters.workers(1) as cluster:
        threading.Thread(target=kill).start()
        clusters.play(suite, tmp_path / "out", cluster, tell)
    assert killed.is_set()
    assert any("1 workers were lost while they played it" in one.problem for one in failures)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_solvers_end_with_the_command_that_asked_for_them(suite: Path, tmp_path: Path, how: int) -> None:
    suite.write_text(SUITE.replace("trials = [5, 20]", "time = 100.0"))
    command = [sys.executable, "-c", "from hypgen.cli.main import main; main()", "bench", str(suite)]
    with clusters.workers(2) as cluster:
        address = cluster.scheduler_address
        process = subprocess.Popen([*command, "-o", str(tmp_path / "out"), "--dask", address])
        clusters.wait(lambda: len(clusters.solvers()) == 2, 120.0)
        process.send_signal(how)
        clusters.wait(lambda: not clusters.solvers(), 60.0)
        assert process.wait() == (130 if how == signal.SIGINT else -how)


def test_a_suite_ends_where_its_scheduler_is_lost(suite: Path, tmp_path: Path) -> None:
    cell = Cell(read_suite(suite).studies[0].settings[0], "0" * 16, 0, 2)
    with LocalCluster(n_workers=0, processes=False, dashboard_address=":0", protocol="tcp") as made:
        executor = DaskExecutor(made.scheduler_address)
        threading.Timer(0.2, made.close).start()
        with pytest.raises(SuiteError, match="the Dask scheduler is lost"):
            list(executor.play([cell], Store(tmp_path)))
