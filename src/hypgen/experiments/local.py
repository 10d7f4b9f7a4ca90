# SPDX-License-Identifier: Apache-2.0
"""Plays cells on this machine: several processes at a time, each on cores, and a GPU, of its own."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hypgen.experiments.cells import Cell
from hypgen.experiments.lines_folder import lines_folder
from hypgen.experiments.process import POLL, SolverProcess
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite_values import SuiteError


@dataclass
class Running:
    """A process that plays a cell, and what it holds."""

    cell: Cell
    process: SolverProcess
    cores: list[int]
    gpu: str | None


@dataclass
class LocalExecutor:
    """This machine's cores and GPUs.

    ``programs`` are the solvers by task. A process that plays a cell for ``cell_seconds`` is killed.
    ``about`` says how the programs were compiled.
    """

    programs: dict[str, Path]
    jobs: int
    gpus: list[str]
    cell_seconds: float
    about: dict[str, Any] = field(default_factory=dict)
    cores: list[int] = field(default_factory=lambda: sorted(os.sched_getaffinity(0)))

    def __post_init__(self) -> None:
        self.size = len(self.cores)

    def play(self, cells: Sequence[Cell], store: Store, end: float = math.inf) -> Iterator[Cell | Failure]:
        """Play cells in about their order, keep each, and yield it.

        At ``end``, or where the iterator is closed, all processes are ended.
        A setting one of whose cells fails is not played on.
        """
        waiting, running = list(cells), list[Running]()
        if not self.gpus and (cell := next((one for one in waiting if one.setting.wants_gpu), None)):
            raise SuiteError(f"`{cell.setting}` needs a GPU, and none may be used")
        # Whatever an interrupt leaves, the folder goes, with all that processes write.
        with lines_folder(store.folder) as folder:
            try:
                while (waiting or running) and time.monotonic() < end:
                    while (cell := self._next(waiting)) is not None:
                        waiting.remove(cell)
                        running.append(self._start(cell, folder))
                    time.sleep(POLL)
                    for one in [one for one in running if one.process.has_ended()]:
                        running.remove(one)
                        self._free(one)
                        outcome = one.process.played().keep(one.cell, store)
                        if isinstance(outcome, Failure):
                            waiting = [cell for cell in waiting if cell.setting != one.cell.setting]
                        yield outcome
            finally:
                for one in running:
                    one.process.ask_to_end()
                for one in running:
                    one.process.stop()

    def _next(self, waiting: Sequence[Cell]) -> Cell | None:
        """Return the next cell that could start now.

        Those of later waves wait, as small ones would else keep one with many cores out until the end.
        """
        this_wave = (one for one in waiting if one.wave == waiting[0].wave)
        return next((one for one in this_wave if self._has_room(one)), None)

    def _has_room(self, cell: Cell) -> bool:
        """Return whether a cell could start now. One with more threads than cores takes all cores."""
        has_cores = len(self.cores) >= min(cell.setting.threads, self.size)
        return self.jobs > 0 and has_cores and (bool(self.gpus) or not cell.setting.wants_gpu)

    def _start(self, cell: Cell, folder: Path) -> Running:
        count = min(cell.setting.threads, self.size)
        mine, self.cores = self.cores[:count], self.cores[count:]
        gpu = self.gpus.pop(0) if cell.setting.wants_gpu else None
        self.jobs -= 1
        command = [str(self.programs[cell.setting.task.name]), *cell.arguments()]
        lines = folder / cell.key
        process = SolverProcess(command, lines, mine, gpu, self.about, self.cell_seconds, cell.param)
        return Running(cell, process, mine, gpu)

    def _free(self, one: Running) -> None:
        self.cores = sorted(self.cores + one.cores)
        self.gpus += [] if one.gpu is None else [one.gpu]
        self.jobs += 1
