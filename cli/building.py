# SPDX-License-Identifier: Apache-2.0
"""Builds the programs that commands start, and tells the user what is built and why."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from hypgen.cli.output import say
from hypgen.cli.progress import notice

if TYPE_CHECKING:  # at run time only where something is built
    from hypgen.api.model import Model
    from hypgen.dsl.load import Loaded
    from hypgen.runtime.builder.cuda_tools import CudaBuild
    from hypgen.runtime.builder.solver import Step


def build(
    kind: str,
    loaded: Loaded,
    model: Path,
    instance: Path | None,
    cuda: CudaBuild | None = None,
    force: bool = False,
    files: dict[str, str] | None = None,
) -> Path:
    """Return a program of one of ``programs.KINDS``; ``force`` compiles what has not changed, too.

    ``files`` are those of the program, if they are known.
    """
    if files is None:
        from hypgen.api import programs

        with generating(model):
            files = programs.files(loaded, kind)
    with _spinner():
        return as_model(loaded, model, instance).program(
            kind, cuda=cuda, again=force, progress=report, generated=files
        )


def generating(model: Path) -> contextlib.AbstractContextManager[None]:
    """Say, where that takes long, that a model's code is being generated."""
    return notice(f"{model}: generating code")


def as_model(loaded: Loaded, model: Path, instance: Path | None) -> Model:
    """Return a model that a command has read as Python has it."""
    from hypgen.api.model import Model, origin_of

    return Model(loaded, origin_of(model, instance))


def report(step: Step) -> None:
    """Say what is built and why."""
    say(f"{step.what}: {'compiling (' + step.reason + ')' if step.reason else 'cached'}")


def _spinner() -> contextlib.AbstractContextManager[object]:
    """Return something that turns while the compiler runs, where a person watches."""
    if not sys.stderr.isatty():
        return contextlib.nullcontext()
    from rich.console import Console

    return Console(stderr=True).status("compiling")
