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
    """Episodes ``first`` to ``first + runs - 1`` of a setting. ``program`` names the generated code."""

    setting: Setting
    program: str
    first: int
    runs: int

    def arguments(self) -> list[str]:
        """Return what the solver is told, but for files."""
        return [*self.setting.arguments(), f"--first-run={self.first}", f"--runs={self.runs}"]

    @property
    def key(self) -> str:
        """A name that changes with the program, its options, its params and its episodes alone."""
        param = self.setting.task.param
        parts = [self.program, *self.arguments(), "" if param is None else param.read_text(encoding="utf-8")]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:20]


def cells_of(studies: Iterable[Study], programs: dict[str, str]) -> list[Cell]:
    """Return the cells of studies in the order to play them, each once.

    ``programs`` has the name of the generated code of each task. The cells come in waves: the first of each
    setting, then the second. So all settings have played about as much whenever time is up. Within a wave
    those with many cores come first, as the others fit beside and behind them, and of these the quick ones.
    """
    cells = [
        (
            first // study.episodes_a_cell,
            Cell(setting, programs[setting.task.name], first, min(study.episodes_a_cell, study.runs - first)),
        )
        for study in studies
        for setting in study.settings
        for first in range(0, study.runs, study.episodes_a_cell)
    ]
    cells.sort(key=lambda one: (one[0], -one[1].setting.threads, one[1].setting.seconds))
    return list({cell.key: cell for _, cell in cells}.values())
