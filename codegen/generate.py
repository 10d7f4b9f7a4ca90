# SPDX-License-Identifier: Apache-2.0
"""The way from a checked model to the files of a C++ project."""

from __future__ import annotations

from hypgen.codegen.fill_templates import (
    render,
    render_exact,
    render_library,
    render_ros2,
    render_verify,
)
from hypgen.codegen.project import lower, lower_embedded, project_view
from hypgen.codegen.ros2.packages import packages
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


def generate_verify(model: ir.Model) -> dict[str, str]:
    """Return the program that checks the code of the model's planner."""
    return render_verify(*lower(model))


def generate_library(model: ir.Model) -> dict[str, str]:
    """Return the files of the libraries that programs embed, without a program."""
    return render_library(*lower_embedded(model))


def generate_ros2(model: ir.Model) -> tuple[str, dict[str, str]]:
    """Return the files of a model's two ROS 2 packages; before them, the folder of the solver's project."""
    ros = packages(model)
    folder = f"{ros.stem}_planner/solver"
    project = {f"{folder}/{path}": text for path, text in generate(model).items()}
    return folder, render_ros2(project_view(model), ros) | project
