# SPDX-License-Identifier: Apache-2.0
"""Plays cells on several machines: the workers of a Dask scheduler."""

from __future__ import annotations

import math
import re
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from queue import Empty, Queue
from typing import TYPE_CHECKING, Any

from hypgen import __version__
from hypgen.experiments import worker
from hypgen.experiments.cells import Cell
from hypgen.experiments.generated import generate, program_of
from hypgen.experiments.process import Played
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import Task
from hypgen.experiments.suite_values import SuiteError

if TYPE_CHECKING:
    from distributed import Client, Future

Worker = Mapping[str, Any]  # what the scheduler tells of a worker
Needs = dict[str, float]  # resources, by Dask's names
REACH = 10.0  # seconds in which a scheduler has to answer
_ADDRESS = re.compile(r"((tcp|tls|ucx|wss?|inproc)://)?[^\s/]+(:\d+)?(/\S*)?")  # of a scheduler
_LOOK = 1.0  # seconds between two looks at the workers
_AHEAD = 2  # cells for each thread of a worker: one plays, one waits


class DaskExecutor:
    """The workers of a Dask scheduler; ``scheduler`` is its address, or a cluster object of Dask.

    A process that plays a cell for ``cell_seconds`` is killed. Where no worker can take what is left for
    ``patience`` seconds, ``play`` gives up. Raises ``SuiteError`` where the scheduler does not answer.
    """

    def __init__(self, scheduler: Any, cell_seconds: float = 3600.0, patience: float = 60.0) -> None:
        self._cell_seconds, self._patience = cell_seconds, patience
        self._client = _connect(scheduler)
        self._projects: dict[Task, bytes] = {}
        self._submitted = 0

    def close(self) -> None:
        """Leave the scheduler."""
        self._client.close()

    def play(self, cells: Sequence[Cell], store: Store, end: float = math.inf) -> Iterator[Cell | Failure]:
        """Play cells in about their order, keep each, and yield it.

        At ``end``, or where the iterator is closed, all processes are ended.
        A setting one of whose cells fails is not played on. A cell whose worker is lost plays on another.
        """
        waiting = list(cells)
        playing: dict[Future[Played], tuple[Cell, Needs]] = {}
        ended: Queue[Future[Played]] = Queue()
        able = time.monotonic()
        try:
            while (waiting or playing) and time.monotonic() < end:
                workers = self._workers()
                for cell, needs in _next(waiting, [one for one, _ in playing.values()], workers):
                    waiting.remove(cell)
                    future = self._submit(cell, needs)
                    playing[future] = cell, needs
                    future.add_done_callback(ended.put)
                left = chain(playing.values(), ((one, _needs(one, workers)) for one in waiting))
                cell, needs = first = next(left)
                if any(_has(one, needs) for _, needs in chain([first], left) for one in workers):
                    able = time.monotonic()
                elif time.monotonic() - able >= self._patience:
                    raise SuiteError(_stuck(cell, needs, workers))
                try:
                    future = ended.get(timeout=_LOOK)
                except Empty:
                    continue
                cell, _ = playing.pop(future)
                if future.status in ("cancelled", "lost"):  # somebody has restarted the workers
                    waiting.insert(0, cell)
                    continue
                outcome = _played(future).keep(cell, store)
                if isinstance(outcome, Failure):
                    waiting = [one for one in waiting if one.setting != cell.setting]
                yield outcome
        finally:
            if playing and self._client.status == "running":
                self._client.cancel(list(playing), force=True)

    def _workers(self) -> list[Worker]:
        """Return what the scheduler tells of its workers: none while the client connects to it again."""
        info = self._client.scheduler_info(n_workers=-1) if self._client.status == "running" else {}
        if self._client.status == "closed":
            raise SuiteError("the Dask scheduler is lost; run the command again to go on")
        return list(info.get("workers", {}).values())

    def _submit(self, cell: Cell, needs: Needs) -> Future[Played]:
        setting = cell.setting
        work = worker.Work(
            cell.program,
            self._project(cell),
            tuple(cell.arguments()),
            cell.param,
            setting.threads,
            setting.wants_gpu,
            self._cell_seconds,
            __version__,
        )
        self._submitted += 1
        return self._client.submit(
            worker.play,
            work,
            key=f"hypgen-{cell.key}-{uuid.uuid4().hex}",
            resources=needs,
            priority=-self._submitted,
        )

    def _project(self, cell: Cell) -> bytes:
        """Return the generated files of a cell's task, packed."""
        task = cell.setting.task
        if task not in self._projects:
            _, files = generate(task)
            if program_of(files) != cell.program:
                raise SuiteError(f"the model of the task {task.name} was changed; run the command again")
            self._projects[task] = worker.pack(files)
        return self._projects[task]


def _connect(scheduler: Any) -> Client:
    try:
        from distributed import Client
    except ImportError:
        raise SuiteError("several machines need Dask: pip install 'hypgen[dask]'") from None
    silent = SuiteError(
        f"no Dask scheduler answers at '{scheduler}': `dask scheduler` starts one and prints its address"
    )
    if isinstance(scheduler, str) and not _ADDRESS.fullmatch(scheduler):
        raise silent
    try:
        return Client(scheduler, timeout=REACH, set_as_default=False)
    except (OSError, ValueError, TimeoutError):
        raise silent from None


def _next(
    waiting: Sequence[Cell], playing: Sequence[Cell], workers: Sequence[Worker]
) -> list[tuple[Cell, Needs]]:
    """Return the cells to send to the workers now. Those for GPUs do not keep others from other workers."""
    on_gpu = [cell.setting.wants_gpu for cell in playing]
    room = {
        gpu: _AHEAD * sum(one["nthreads"] for one in workers if _has(one, {"GPU": 1} if gpu else {}))
        - on_gpu.count(gpu)
        for gpu in (False, True)
    }
    found = []
    for cell in waiting:
        if max(room.values()) <= 0:
            break
        gpu, needs = cell.setting.wants_gpu, _needs(cell, workers)
        if room[gpu] > 0 and any(_has(one, needs) for one in workers):
            room[gpu] -= 1
            found.append((cell, needs))
    return found


def _needs(cell: Cell, workers: Sequence[Worker]) -> Needs:
    """Return the resources that a cell asks for. One with more threads than any worker's cores takes all."""
    gpu = {"GPU": 1.0} if cell.setting.wants_gpu else {}
    cores = max((one["resources"].get("CORES", 0.0) for one in workers if _has(one, gpu)), default=0.0)
    if not any("CORES" in one["resources"] for one in workers):
        return gpu
    return {"CORES": min(float(cell.setting.threads), cores or float("inf"))} | gpu


def _has(worker: Worker, needs: Needs) -> bool:
    """Return whether a worker has what a cell needs."""
    return all(worker["resources"].get(name, 0.0) >= need for name, need in needs.items())


def _stuck(cell: Cell, needs: Needs, workers: Sequence[Worker]) -> str:
    if not workers:
        return "the Dask scheduler has no workers: `dask worker ADDRESS` starts one"
    named = " ".join(f"{name}={need:g}" for name, need in needs.items())
    return f'no worker can play `{cell.setting}`: start one with --resources "{named}"'


def _played(future: Future[Played]) -> Played:
    """Return what a worker has answered, or why it has not."""
    from distributed import KilledWorker

    error = future.exception()
    if error is None:
        answer: Played = future.result()
        return answer
    if isinstance(error, KilledWorker):
        return Played({}, "", f"{error.allowed_failures + 1} workers were lost while they played it")
    return Played({}, "", f"the worker failed: {type(error).__name__}: {error}")
