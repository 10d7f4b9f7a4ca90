# SPDX-License-Identifier: Apache-2.0
"""A checked model, and the way to its library."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypgen.api import html, programs
from hypgen.api.programs import Progress
from hypgen.api.solver import Solver
from hypgen.dsl import load as driver
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.runtime.builder import cuda_tools

if TYPE_CHECKING:
    from hypgen.api.environments import WorldEnv

FilePath = str | os.PathLike[str]
TARGETS = ("auto", "cpu", "cuda", "both")


@dataclass(frozen=True)
class Model:
    """A model without mistakes; ``load`` makes one."""

    loaded: driver.Loaded
    origin: str  # the files that it was read from

    @property
    def name(self) -> str:
        """The model's name in its file."""
        return self.loaded.model.name

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What is allowed in the model and yet doubtful."""
        return self.loaded.warnings

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the model's parts and its warnings."""
        model = self.loaded.model
        rows: list[tuple[str, object]] = [
            ("action", f"{model.action.name}: {model.action.type}, {model.action.count} in all"),
            *(("visible" if v.visible else "hidden", f"{v.name}: {v.type}") for v in model.variables),
            *(("observed", f"{o.name}: {o.type}") for o in model.observations),
            ("discount", f"{model.discount:g}"),
            *((f"warning {warning.code}", warning.message) for warning in self.warnings),
        ]
        return html.table(f"model {self.name}", rows)

    def compile(self, *, target: str = "auto", progress: Progress | None = None) -> Solver:
        """Return the model's solver, compiled unless the cache has it.

        ``target`` is that of ``hypgen compile``. ``progress`` is told of what is built, and why.
        """
        if target not in TARGETS:
            raise ValueError(f"target: expected {', '.join(TARGETS)}, found {target!r}")
        return Solver(
            self.program("library", cuda=cuda_tools.choose(target, "", "").build, progress=progress)
        )

    def program(
        self,
        kind: str,
        *,
        cuda: cuda_tools.CudaBuild | None = None,
        again: bool = False,
        progress: Progress | None = None,
        generated: dict[str, str] | None = None,
    ) -> Path:
        """Return a program of one of ``programs.KINDS``, as ``programs.program`` does."""
        return programs.program(
            self.loaded,
            kind,
            self.origin,
            cuda=cuda,
            again=again,
            progress=progress,
            generated=generated,
        )

    def env(self, **settings: Any) -> WorldEnv:
        """Compile the model and return ``Solver.env`` with these settings."""
        return self.compile().env(**settings)


def load(path: FilePath, instance: FilePath | None = None, **values: Any) -> Model:
    """Return the model of a file; mistakes raise ``ModelError``, which holds the diagnostics.

    ``values`` set consts and params of the model. A value is a number, a bool, a list of values, or a text
    as in the model.
    """
    settings = [f"{name}={text_of(value)}" for name, value in values.items()]
    loaded = driver.load(path, instance=instance, settings=settings)
    return Model(loaded, origin_of(path, instance))


def origin_of(path: FilePath, instance: FilePath | None) -> str:
    """Return how a model's files are named together."""
    return " ".join(str(Path(file).absolute()) for file in (path, instance) if file is not None)


def text_of(value: Any) -> str:
    """Return a value as a model writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(text_of, value))}]"
    return str(value)
