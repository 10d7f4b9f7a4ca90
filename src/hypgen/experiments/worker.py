# SPDX-License-Identifier: Apache-2.0
"""Plays a cell on a worker of Dask: compiles its solver there, and returns what it wrote."""

from __future__ import annotations

import contextlib
import json
import tempfile
import time
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypgen import __version__
from hypgen.experiments.generated import program_of
from hypgen.experiments.process import POLL, Played, SolverProcess
from hypgen.experiments.shares import Stopped, held, visible_cores, visible_gpus
from hypgen.runtime.builder import cuda_tools
from hypgen.runtime.builder.errors import BuildError, ToolchainError
from hypgen.runtime.builder.solver import Step, build_solver
from hypgen.runtime.builder.tools import find_compiler

# What this worker has compiled, or found in its machine's cache: the solver, and its compiler.
_SOLVERS: dict[tuple[str, bool], tuple[Path, str]] = {}


@dataclass(frozen=True)
class Work:
    """A cell by value. ``project`` has the generated files, packed; ``param`` is the text of a JSON file."""

    program: str
    project: bytes
    arguments: tuple[str, ...]
    param: str | None
    threads: int
    wants_gpu: bool
    seconds: float
    version: str


def pack(files: Mapping[str, str]) -> bytes:
    """Return generated files as ``Work`` has them."""
    return zlib.compress(json.dumps(dict(files)).encode())


def play(work: Work) -> Played:
    """Play a cell on cores, and with a GPU, of its own; a problem is returned, not raised.

    Dask cannot end a function that runs. So this one looks whether its result is still wanted: it is not
    where the client has cancelled it, or is gone.
    """
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def is_stopped() -> bool:
        task = worker.state.tasks.get(key)
        return task is None or task.state != "executing"

    about = {"worker": worker.address}
    try:
        solver, compiler = _solver(work, is_stopped)
        gpus = visible_gpus(int(worker.state.total_resources.get("GPU", 0))) if work.wants_gpu else []
        return _play(work, solver, gpus, {**about, "compiler": compiler}, is_stopped)
    except Stopped:
        return Played(about, "", "cancelled")
    except (ToolchainError, BuildError, _Refused) as error:
        return Played(about, "", f"the worker {worker.address}: {' '.join(str(error).split())}")


class _Refused(Exception):
    """This worker would play something else than the client asks for."""


def _solver(work: Work, is_stopped: Callable[[], bool]) -> tuple[Path, str]:
    """Return the solver, compiled unless this machine has it, and the version of its compiler."""
    name = (work.program, work.wants_gpu)
    if name in _SOLVERS and _SOLVERS[name][0].is_file():
        return _SOLVERS[name]
    files = json.loads(zlib.decompress(work.project))
    if program_of(files) != work.program:
        raise _Refused(
            f"its hypgen {__version__} has another runtime than the client's {work.version}; "
            "install the same on all machines"
        )
    cuda = cuda_tools.choose("cuda" if work.wants_gpu else "cpu").build
    holding, is_alone = contextlib.ExitStack(), False

    def alone(step: Step) -> None:
        """Take the whole machine before something is compiled: others may be playing against time."""
        nonlocal is_alone
        if step.reason and not is_alone:
            holding.enter_context(held(len(visible_cores()), [], is_stopped))
            is_alone = True

    with holding:
        solver = build_solver(files, f"worker {work.program}", alone, cuda=cuda)
    compiler = find_compiler()
    _SOLVERS[name] = solver, compiler.version if compiler else ""
    return _SOLVERS[name]


def _play(
    work: Work, solver: Path, gpus: list[str], about: dict[str, Any], is_stopped: Callable[[], bool]
) -> Played:
    with (
        tempfile.TemporaryDirectory(prefix="hypgen-") as folder,
        held(work.threads, gpus, is_stopped) as mine,
    ):
        command = [str(solver), *work.arguments]
        process = SolverProcess(command, Path(folder) / "lines", *mine, about, work.seconds, work.param)
        try:
            while not process.has_ended():
                if is_stopped():
                    raise Stopped
                time.sleep(POLL)
            return process.played()
        except Stopped:
            process.stop()
            raise
