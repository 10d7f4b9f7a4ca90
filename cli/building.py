# SPDX-License-Identifier: Apache-2.0
"""Builds the programs that commands start, and tells the user what is built and why."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from hypgen.cli.output import say

if TYPE_CHECKING:  # at run time only where something is built
    from hypgen.dsl.load import Loaded
    from hypgen.runtime.builder.cuda_tools import CudaBuild
    from hypgen.runtime.builder.solver import Step


def build_online(
    loaded: Loaded, model: Path, instance: Path | None, cuda: CudaBuild | None, force: bool = False
) -> Path:
    """Return the program that plans online for a model; ``force`` compiles what has not changed, too."""
    from hypgen.codegen import generate

    return build(loaded, generate.generate(loaded.model), model, instance, cuda, force)


def build_exact(
    loaded: Loaded, model: Path, instance: Path | None, force: bool = False, precise: bool = False
) -> Path:
    """Return the exact solver's program for a model; refuse one whose outcomes cannot be tried one by one.

    ``precise``: constant probabilities are those of the text, not those that a planner draws with.
    """
    from hypgen.codegen import generate
    from hypgen.codegen.passes.enumerable import not_enumerable
    from hypgen.dsl.messages.diagnostic import ModelError

    if found := not_enumerable(loaded.model):
        raise ModelError(found, loaded.sources)
    return build(loaded, generate.generate_exact(loaded.model, precise), model, instance, None, force)


def build_verify(loaded: Loaded, model: Path, instance: Path | None, cuda: CudaBuild | None = None) -> Path:
    """Return the program that checks the code of a model's planner."""
    from hypgen.codegen import generate

    return build(loaded, generate.generate_verify(loaded.model), model, instance, cuda, force=False)


def build(
    loaded: Loaded,
    files: dict[str, str],
    model: Path,
    instance: Path | None,
    cuda: CudaBuild | None,
    force: bool,
) -> Path:
    """Return the executable of a generated project."""
    from hypgen.runtime.builder import solver

    origin = " ".join(str(path.absolute()) for path in (model, instance) if path is not None)
    with _spinner():
        return solver.build_solver(
            files, origin, _report, model=loaded.model.source_hash, cuda=cuda, again=force
        )


def _report(step: Step) -> None:
    """Say what is built and why."""
    say(f"{step.what}: {'compiling (' + step.reason + ')' if step.reason else 'cached'}")


def _spinner() -> contextlib.AbstractContextManager[object]:
    """Return something that turns while the compiler runs, where a person watches."""
    if not sys.stderr.isatty():
        return contextlib.nullcontext()
    from rich.console import Console

    return Console(stderr=True).status("compiling")
