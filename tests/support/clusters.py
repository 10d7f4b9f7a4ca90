# SPDX-License-Identifier: Apache-2.0
"""Workers of Dask on this machine, and suites that lose some of them."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
from distributed import LocalCluster

import hypgen
from hypgen.experiments.cluster import DaskExecutor
from hypgen.experiments.running import State
from hypgen.experiments.tables import markdown
from support.paths import ROOT

SUITE = f"""
title = "Tigers"
[tasks.tiger]
model = "{ROOT / "examples" / "tiger.pomdp"}"
[[study]]
name = "trials"
runs = 6
episodes_a_cell = 2
play = ["despot"]
trials = [5, 20]
scenarios = 50
steps = 6
"""


@contextmanager
def workers(count: int) -> Iterator[LocalCluster]:
    """Yield a cluster of worker processes with a core each, which are started again where they die."""
    with LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        resources={"CORES": 1},
        protocol="tcp",
        dashboard_address=":0",
    ) as cluster:
        yield cluster


def play(
    suite: Path, folder: Path, cluster: LocalCluster, tell: Callable[[State], None] = lambda state: None
) -> list[str]:
    """Play a suite on a cluster, and return its tables."""
    executor = DaskExecutor(cluster.scheduler_address)
    try:
        return texts(hypgen.bench(suite, folder, executor=executor, tell=tell))
    finally:
        executor.close()


def texts(tables: list) -> list[str]:
    """Return tables without the column of seconds."""
    pages = [markdown(table).splitlines() for table in tables]
    return ["\n".join("|".join(row.split("|")[:8] + row.split("|")[9:]) for row in page) for page in pages]


def kill_a_busy_worker(cluster: LocalCluster) -> None:
    """Kill the process of a worker that has cells to play."""
    busy = next((one for one in cluster.scheduler.workers.values() if one.processing), None)
    if busy is not None:
        os.kill(
            next(n.pid for n in cluster.workers.values() if n.worker_address == busy.address), signal.SIGKILL
        )


def solvers() -> list[psutil.Process]:
    """Return the solvers that the workers of this process have started."""
    return [one for one in psutil.Process().children(recursive=True) if _is_solver(one)]


def _is_solver(process: psutil.Process) -> bool:
    try:
        return process.name() == "tiger"
    except psutil.NoSuchProcess:  # it has ended since it was listed
        return False


def wait(condition: Callable[[], object], seconds: float = 30.0) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)
