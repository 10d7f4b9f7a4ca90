# SPDX-License-Identifier: Apache-2.0
"""The code that is generated of a task, and its name."""

from __future__ import annotations

from collections.abc import Mapping

from hypgen.api import model as models
from hypgen.api import programs
from hypgen.api.model import Model
from hypgen.experiments.suite import Task
from hypgen.runtime.builder import cache
from hypgen.runtime.builder.solver import runtime_id


def generate(task: Task) -> tuple[Model, dict[str, str]]:
    """Return a task's model, and the files of its solver."""
    values = dict(setting.split("=", 1) for setting in task.settings)
    model = models.load(task.model, task.instance, **values)
    return model, programs.files(model.loaded, "solver")


def program_of(files: Mapping[str, str]) -> str:
    """Return the name of generated code with the runtime of this hypgen."""
    return cache.digest(runtime_id(), *(part for item in sorted(files.items()) for part in item))[:16]
