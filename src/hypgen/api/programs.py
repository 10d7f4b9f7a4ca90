# SPDX-License-Identifier: Apache-2.0
"""The programs of a model: what is generated for each kind, built once and kept in the cache."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hypgen.codegen import generate
from hypgen.codegen.passes.enumerable import not_enumerable
from hypgen.dsl.load import Loaded
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.runtime.builder.solver import Step, build_solver

if TYPE_CHECKING:
    from hypgen.runtime.builder.cuda_tools import CudaBuild

Progress = Callable[[Step], None]

# solver: plans online. library: the same for other programs. verify: checks the code of both.
# exact: solves, with the probabilities that a planner draws with. precise: with those of the text.
KINDS = ("solver", "library", "verify", "exact", "precise")


def files(loaded: Loaded, kind: str) -> dict[str, str]:
    """Return the files of a program of a kind; refuse to solve a model with continuous draws."""
    if kind in ("exact", "precise") and (found := not_enumerable(loaded.model)):
        raise ModelError(found, loaded.sources)
    match kind:
        case "solver":
            return generate.generate(loaded.model)
        case "library":
            return generate.generate_library(loaded.model)
        case "verify":
            return generate.generate_verify(loaded.model)
        case "exact" | "precise":
            return generate.generate_exact(loaded.model, precise=kind == "precise")
    raise ValueError(f"kind: expected {', '.join(KINDS)}, found {kind!r}")


def program(
    loaded: Loaded,
    kind: str,
    origin: str,
    *,
    cuda: CudaBuild | None = None,
    again: bool = False,
    progress: Progress | None = None,
    generated: dict[str, str] | None = None,
) -> Path:
    """Return a program of a kind, compiled unless the cache has it.

    ``origin`` names the model's files. ``cuda`` says how to compile for GPUs too. ``again`` compiles what
    has not changed. ``progress`` is told of what is built, and why. ``generated`` are the files, if known.
    """
    return build_solver(
        files(loaded, kind) if generated is None else generated,
        origin,
        progress or (lambda step: None),
        model=loaded.model.source_hash,
        cuda=cuda,
        again=again,
    )
