# SPDX-License-Identifier: Apache-2.0
"""Plays a suite: compiles its tasks, plays what its folder lacks, and makes its tables."""

from __future__ import annotations

import math
import os
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from hypgen.api.model import FilePath
from hypgen.api.programs import Progress
from hypgen.dsl import ir
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.experiments.cells import Cell, cells_of
from hypgen.experiments.generated import generate, program_of
from hypgen.experiments.local import LocalExecutor
from hypgen.experiments.record import record
from hypgen.experiments.results import read
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import Suite, Task, read_suite
from hypgen.experiments.suite_values import SuiteError
from hypgen.runtime.builder import cuda_tools
from hypgen.runtime.builder.tools import find_compiler

if TYPE_CHECKING:
    from hypgen.experiments.tables import Table


class Executor(Protocol):
    """What plays cells: this machine, or several."""

    def play(self, cells: Sequence[Cell], store: Store, end: float = math.inf) -> Iterator[Cell | Failure]:
        """Play cells in about their order, keep each in the store, and yield it.

        At ``end``, a time of ``time.monotonic()``, what plays is ended and dropped.
        """
        ...


@dataclass(frozen=True)
class Build:
    """A task's solver, and the name of the code that it was generated from."""

    solver: Path
    program: str
    model: ir.Model


@dataclass
class State:
    """How far a suite is: ``done`` of ``total`` cells are played; some failed, now or in an earlier call."""

    total: int
    done: int
    failures: list[Failure] = field(default_factory=list)
    last: Cell | None = None


def build(suite: Suite, target: str = "auto", progress: Progress | None = None) -> dict[str, Build]:
    """Return the solver of each task that plays, compiled unless the cache has it, by the task's name."""
    settings = [setting for study in suite.studies for setting in study.settings]
    tasks = list(dict.fromkeys(setting.task for setting in settings))

    def one(task: Task) -> Build:
        return _build(task, any(s.wants_gpu for s in settings if s.task == task), target, progress)

    # A build uses several cores itself.
    with ThreadPoolExecutor(max(1, (os.cpu_count() or 1) // 4)) as pool:
        return dict(zip((task.name for task in tasks), pool.map(one, tasks), strict=True))


def _build(task: Task, wants_gpu: bool, target: str, progress: Progress | None) -> Build:
    model, files = generate(task)
    cuda = cuda_tools.choose(target if wants_gpu else "cpu", "", "").build
    solver = model.program("solver", cuda=cuda, progress=progress, generated=files)
    return Build(solver, program_of(files), model.loaded.model)


def check_options(suite: Suite, builds: dict[str, Build]) -> None:
    """Raise ``SuiteError`` where solvers lack an option of the suite, or models what it measures."""
    known = {name: _options_of(one.solver) for name, one in builds.items()}
    for study in suite.studies:
        for task in dict.fromkeys(setting.task.name for setting in study.settings):
            for measure in study.measures:
                measure.check(builds[task].model, f"study {study.name}, measure {measure.name}")
        for setting in study.settings:
            for name, _ in setting.options:
                option = name.replace("_", "-")
                if option not in known[setting.task.name]:
                    nearest = did_you_mean(option, sorted(known[setting.task.name]))
                    raise SuiteError(
                        f"study {study.name}: solvers have no option `{name}`. {nearest}".strip()
                    )


def _options_of(solver: Path) -> set[str]:
    done = subprocess.run([str(solver), "--help"], capture_output=True, text=True, check=True)
    words = (line.split()[0] for line in done.stdout.splitlines() if line.startswith("  --"))
    return {word.removeprefix("--") for word in words}


def play(
    suite: Suite,
    builds: dict[str, Build],
    store: Store,
    executor: Executor,
    *,
    limit: float | None = None,
    tell: Callable[[State], None] = lambda state: None,
) -> State:
    """Play the cells that the store lacks, for ``limit`` seconds at most; ``tell`` is told after each."""
    cells = cells_of(suite.studies, {name: one.program for name, one in builds.items()})
    left = [cell for cell in cells if not store.has(cell)]
    known = [Failure(cell, problem) for cell in left if (problem := store.failure(cell))]
    failed = {failure.cell.setting for failure in known}
    waiting = [cell for cell in left if cell.setting not in failed]
    state = State(len(cells), len(cells) - len(left), failures=known)
    end = time.monotonic() + (limit if limit is not None else math.inf)
    tell(state)
    playing = executor.play(waiting, store, end)
    try:
        for outcome in playing:
            if isinstance(outcome, Failure):
                state.failures.append(outcome)
            else:
                state.done += 1
                state.last = outcome
            tell(state)
    finally:
        close = getattr(playing, "close", None)
        if close is not None:
            close()
    return state


def describe(suite: Suite, builds: dict[str, Build], store: Store) -> None:
    """Keep in the folder what its cells are; ``builds`` may lack the tasks of studies that do not play."""
    record(suite, {name: one.program for name, one in builds.items()}, store)


def tables(suite: Suite, builds: dict[str, Build], store: Store) -> list[Table]:
    """Return the tables of what is played so far."""
    from hypgen.experiments.tables import tables_of  # with scipy, which playing does without

    names = {name: one.program for name, one in builds.items()}
    return [table for study in suite.studies for table in tables_of(study, read(study, names, store))]


def local(
    builds: dict[str, Build], jobs: int, gpus: list[str], cell_seconds: float = 3600.0
) -> LocalExecutor:
    """Return what plays cells on this machine, ``jobs`` at a time."""
    compiler = find_compiler()
    about: dict[str, Any] = {"compiler": compiler.version if compiler else ""}
    return LocalExecutor({name: one.solver for name, one in builds.items()}, jobs, gpus, cell_seconds, about)


def bench(
    suite: FilePath,
    folder: FilePath,
    *,
    jobs: int = 1,
    gpus: Sequence[str] = (),
    limit: float | None = None,
    retry: bool = False,
    target: str = "auto",
    progress: Progress | None = None,
    tell: Callable[[State], None] = lambda state: None,
    executor: Executor | None = None,
) -> list[Table]:
    """Play what the folder of a suite lacks, and return the tables of what is played.

    ``suite`` is a TOML file. ``jobs`` processes play at a time, each on cores of its own, and each that needs
    one with one of ``gpus``, the numbers of devices. ``limit`` is in seconds. ``retry`` plays again what
    failed. ``progress`` is told of what is compiled, ``tell`` of what is played. ``executor`` plays the cells
    elsewhere. A suite that cannot be played raises ``SuiteError``.
    """
    asked, store = read_suite(Path(suite)), Store(Path(folder))
    store.open(asked.title)
    if retry:
        store.forget_failures()
    builds = build(asked, target, progress)
    check_options(asked, builds)
    describe(asked, builds, store)
    play(asked, builds, store, executor or local(builds, jobs, list(gpus)), limit=limit, tell=tell)
    return tables(asked, builds, store)
