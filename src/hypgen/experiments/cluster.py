# SPDX-License-Identifier: Apache-2.0
"""Plays cells on several machines: the workers of a Dask scheduler."""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from queue import Empty, Queue
from typing import TYPE_CHECKING, Any

from hypgen import __version__
from hypgen.experiments import worker
from hypgen.experiments.cells import Cell
from hypgen.experiments.generated import generate, program_of
from hypgen.experiments.process import Played
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import SuiteError, Task

if TYPE_CHECKING:
    from distributed import Client, Future

REACH = 10.0  # seconds in which a scheduler has to answer
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

    def play(self, cells: Sequence[Cell], store: Store) -> Iterator[Cell | Failure]:
        """Play cells in about their order, keep each, and yield it; closing the iterator ends all processes.

        A setting one of whose cells fails is not played on. A cell whose worker is lost plays on another.
        """
        waiting = list(cells)
        playing: dict[Future[Played], Cell] = {}
        ended: Queue[Future[Played]] = Queue()
        able = time.monotonic()
        try:
            while waiting or playing:
                workers = self._workers()
                room = _AHEAD * sum(one["nthreads"] for one in workers) - len(playing)
                for cell in [one for one in waiting if _fits(one, workers)][: max(0, room)]:
                    waiting.remove(cell)
                    future = self._submit(cell, workers)
                    playing[future] = cell
                    future.add_done_callback(ended.put)
                if any(_fits(one, workers) for one in (*playing.values(), *waiting)):
                    able = time.monotonic()
                elif time.monotonic() - able >= self._patience:
                    raise SuiteError(_stuck((*playing.values(), *waiting)[0], workers))
                try:
                    future = ended.get(timeout=_LOOK)
                except Empty:
                    continue
                cell = playing.pop(future)
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

    def _workers(self) -> list[Mapping[str, Any]]:
        """Return what the scheduler tells of its workers: none while the client connects to it again."""
        info = self._client.scheduler_info(n_workers=-1) if self._client.status == "running" else {}
        if self._client.status == "closed":
            raise SuiteError("the Dask scheduler is lost; run the command again to go on")
        return list(info.get("workers", {}).values())

    def _submit(self, cell: Cell, workers: Sequence[Mapping[str, Any]]) -> Future[Played]:
        setting = cell.setting
        work = worker.Work(
            cell.program,
            self._project(cell),
            tuple(cell.arguments()),
            None if setting.task.param is None else setting.task.param.read_text(encoding="utf-8"),
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
            resources=_needs(cell, workers),
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
    try:
        return Client(scheduler, timeout=REACH, set_as_default=False)
    except (OSError, ValueError, TimeoutError):
        raise SuiteError(
            f"no Dask scheduler answers at '{scheduler}': `dask scheduler` starts one and prints its address"
        ) from None


def _needs(cell: Cell, workers: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the resources that a cell asks for. One with more threads than any worker's cores takes all."""
    cores = max((one["resources"].get("CORES", 0) for one in workers), default=0)
    asked = {"CORES": min(cell.setting.threads, cores)} if cores else {}
    return asked | ({"GPU": 1} if cell.setting.wants_gpu else {})


def _fits(cell: Cell, workers: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether one of the workers has what a cell needs."""
    needs = _needs(cell, workers)
    return any(all(one["resources"].get(name, 0) >= need for name, need in needs.items()) for one in workers)


def _stuck(cell: Cell, workers: Sequence[Mapping[str, Any]]) -> str:
    if not workers:
        return "the Dask scheduler has no workers: `dask worker ADDRESS` starts one"
    needs = " ".join(f"{name}={need:g}" for name, need in _needs(cell, workers).items())
    return f'no worker can play `{cell.setting}`: start one with --resources "{needs}"'


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
