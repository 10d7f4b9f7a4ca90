# SPDX-License-Identifier: Apache-2.0
"""The way from a checked model to the files of a C++ project."""

from __future__ import annotations

from hypgen.codegen.fill_templates import render, render_exact, render_library
from hypgen.codegen.project import lower, lower_embedded
from hypgen.dsl import ir
from hypgen.dsl.ir.precise import with_precise_draws
from hypgen.dsl.messages.watch import Watch, nobody


def generate(model: ir.Model, watch: Watch = nobody) -> dict[str, str]:
    """Return the project's files, keyed by their paths; the same model gives the same bytes.

    ``watch`` sees what each pass makes of the model.
    """
    files = render(*lower_embedded(model, watch))
    watch("print", files)
    return files


def generate_exact(model: ir.Model, precise: bool = False) -> dict[str, str]:
    """Return the exact solver's program; ``precise``: constant probabilities are those of the text."""
    header, main, project = lower(with_precise_draws(model) if precise else model, exact=True)
    return render_exact(header, main, project)


def generate_library(model: ir.Model) -> dict[str, str]:
    """Return the files of the libraries that programs embed, without a program."""
    return render_library(*lower_embedded(model))
