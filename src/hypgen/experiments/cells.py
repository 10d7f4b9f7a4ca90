# SPDX-License-Identifier: Apache-2.0
"""Cells: some episodes of one setting, played by one process and kept in one file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass

from hypgen.experiments.suite import Setting, Study


@dataclass(frozen=True)
class Cell:
    """Episodes ``first`` to ``first + runs - 1`` of a setting. ``program`` names the generated code.

    Cells of an earlier ``wave`` begin before those of a later one.
    """

    setting: Setting
    program: str
    first: int
    runs: int
    wave: int = 0

    def arguments(self) -> list[str]:
        """Return what the solver is told, but for files."""
        return [*self.setting.arguments(), f"--first-run={self.first}", f"--runs={self.runs}"]

    @property
    def param(self) -> str | None:
        """The JSON text of the params that the episodes play with; None where they are the model's own.

        Of a list of objects the cells of a study take one after the other.
        """
        path = self.setting.task.param
        if path is None:
            return None
        text = path.read_text(encoding="utf-8")
        found = json.loads(text)
        return json.dumps(found[self.wave % len(found)]) if isinstance(found, list) else text

    @property
    def key(self) -> str:
        """A name that changes with the program, its options, its params and its episodes alone."""
        parts = [self.program, *self.arguments(), self.param or ""]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:20]


def cells_of(studies: Iterable[Study], programs: dict[str, str]) -> list[Cell]:
    """Return the cells of studies in the order to play them, each once.

    ``programs`` has the name of the generated code of each task. The cells come in waves: the first of each
    setting, then the second. So all settings have played about as much whenever time is up. Within a wave
    those with many cores come first, as the others fit beside and behind them, and of these the quick ones.
    """
    cells = [
        Cell(
            setting,
            programs[setting.task.name],
            first,
            min(study.episodes_a_cell, study.runs - first),
            first // study.episodes_a_cell,
        )
        for study in studies
        for setting in study.settings
        for first in range(0, study.runs, study.episodes_a_cell)
    ]
    cells.sort(key=lambda one: (one.wave, -one.setting.threads, one.setting.seconds))
    distinct: dict[str, Cell] = {}
    for cell in cells:
        distinct.setdefault(cell.key, cell)
    return list(distinct.values())
