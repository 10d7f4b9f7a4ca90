# SPDX-License-Identifier: Apache-2.0
"""Plays cells on this machine: several processes at a time, each on cores, and a GPU, of its own."""

from __future__ import annotations

import os
import platform
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hypgen import __version__
from hypgen.experiments.cells import Cell
from hypgen.experiments.store import Failure, Store

PATIENCE = 10.0  # seconds that a solver has to end its step once it is asked to stop
_POLL = 0.02  # seconds between two looks at the processes


@dataclass
class Running:
    """A process that plays a cell, and what it holds."""

    cell: Cell
    process: subprocess.Popen[str]
    cores: list[int]
    gpu: str | None
    about: dict[str, Any]
    began: float


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

    def play(self, cells: Sequence[Cell], store: Store) -> Iterator[Cell | Failure]:
        """Play cells in about their order, keep each, and yield it; closing the iterator ends all processes.

        A setting one of whose cells fails is not played on.
        """
        waiting, running = list(cells), list[Running]()
        try:
            while waiting or running:
                while (cell := next((one for one in waiting if self._has_room(one)), None)) is not None:
                    waiting.remove(cell)
                    running.append(self._start(cell, store))
                time.sleep(_POLL)
                for one in [one for one in running if self._has_ended(one)]:
                    running.remove(one)
                    self._free(one)
                    outcome = _keep(one, store)
                    if isinstance(outcome, Failure):
                        waiting = [cell for cell in waiting if cell.setting != one.cell.setting]
                    yield outcome
        finally:
            _stop(running, store)

    def _has_room(self, cell: Cell) -> bool:
        """Return whether a cell could start now. One with more threads than cores takes all cores."""
        has_cores = len(self.cores) >= min(cell.setting.threads, self.size)
        return self.jobs > 0 and has_cores and (bool(self.gpus) or not cell.setting.wants_gpu)

    def _start(self, cell: Cell, store: Store) -> Running:
        count = min(cell.setting.threads, self.size)
        mine, self.cores = self.cores[:count], self.cores[count:]
        gpu = self.gpus.pop(0) if cell.setting.wants_gpu else None
        self.jobs -= 1
        task = cell.setting.task
        command = [str(self.programs[task.name]), *cell.arguments(), "--quiet"]
        command += [f"--json={store.scratch(cell, 'lines')}"]
        command += [] if task.param is None else [f"--param={task.param}"]
        environment = os.environ | ({} if gpu is None else {"CUDA_VISIBLE_DEVICES": gpu})
        about = self.about | {
            "machine": machine(),
            "cores": len(mine),
            "began": datetime.now(UTC).isoformat(timespec="seconds"),
        }
        about["load_average"] = os.getloadavg()
        process = subprocess.Popen(
            ["taskset", "-c", ",".join(map(str, mine)), *command],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        return Running(cell, process, mine, gpu, about, time.monotonic())

    def _has_ended(self, one: Running) -> bool:
        if one.process.poll() is None and time.monotonic() - one.began > self.cell_seconds:
            one.process.kill()
            one.process.wait()
        return one.process.poll() is not None

    def _free(self, one: Running) -> None:
        self.cores = sorted(self.cores + one.cores)
        self.gpus += [] if one.gpu is None else [one.gpu]
        self.jobs += 1


def machine() -> dict[str, Any]:
    """Return what tells results of this machine from those of others."""
    found = {
        "hypgen": __version__,
        "system": f"{platform.system()} {platform.release()}",
        "cores": os.cpu_count(),
    }
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        found["processor"] = next(
            line.split(":")[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        found["processor"] = platform.machine()
    return found


def _keep(one: Running, store: Store) -> Cell | Failure:
    """Keep the lines of a process that has ended, or why there are none."""
    assert one.process.stderr is not None
    problem, code = one.process.stderr.read().strip()[-500:], one.process.returncode
    one.process.stderr.close()
    scratch = store.scratch(one.cell, "lines")
    seconds = time.monotonic() - one.began
    try:
        if code == 0:
            store.put(
                one.cell, {**one.about, "seconds": round(seconds, 3)}, scratch.read_text(encoding="utf-8")
            )
            return one.cell
        reason = (
            f"the solver was ended by signal {-code}" if code < 0 else f"the solver ended with code {code}"
        )
        if code == -signal.SIGKILL:
            reason = f"the solver was killed after {seconds:.0f} s: out of memory, or hung"
        failure = Failure(one.cell, f"{reason}{': ' if problem else ''}{problem}")
        store.fail(failure)
        return failure
    finally:
        scratch.unlink(missing_ok=True)


def _stop(running: list[Running], store: Store) -> None:
    """End the processes; what they have played of their cells is dropped."""
    for one in running:
        one.process.send_signal(signal.SIGTERM)
    for one in running:
        try:
            one.process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            one.process.kill()
            one.process.communicate()
        store.scratch(one.cell, "lines").unlink(missing_ok=True)
