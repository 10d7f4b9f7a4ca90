# SPDX-License-Identifier: Apache-2.0
"""A compiled model: a library in this process, which makes planners."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hypgen.api.c_interface import CLibrary
from hypgen.api.planner import Planner


class Solver:
    """A model's library; ``Model.compile`` makes one, and ``hypgen compile --library`` the file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._library = CLibrary(path)

    @property
    def description(self) -> dict[str, Any]:
        """The model: its names, types, actions, params and hash."""
        found: dict[str, Any] = self._library.json("describe", self._library.model)
        return found

    def planner(
        self, *, params: Mapping[str, Any] | None = None, **settings: str | bool | int | float
    ) -> Planner:
        """Return a planner with settings such as ``mode="despot", time=0.05``: options of the solver.

        An option's dashes become underscores, and one without a value is True. ``params`` sets the
        model's params.
        """
        words = (_setting(name.replace("_", "-"), value) for name, value in settings.items())
        text = None if params is None else json.dumps(dict(params))
        return Planner(self._library, " ".join(word for word in words if word), text)


def _setting(name: str, value: str | bool | int | float) -> str:
    if isinstance(value, bool):
        return name if value else ""
    return f"{name}={value}"
