# SPDX-License-Identifier: Apache-2.0
"""Files in other formats that stand where a model may stand."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # at run time only where a file is in another format
    from hypgen.dsl.foreign.reader import Imported


def import_foreign(
    path: Path, name: str | None, horizon: int | None, tolerance: float | None
) -> Imported | None:
    """Return what a file in another format comes to, None for any other file.

    Rows that are off 1 by at most ``tolerance`` are scaled; None stands for what files round.
    """
    from hypgen.dsl.foreign import files

    content = files.read(path)
    if content is None:
        return None
    from hypgen.dsl.foreign.reader import import_text
    from hypgen.dsl.foreign.tables.rows import TOLERANCE

    return import_text(str(path), content, name, horizon, TOLERANCE if tolerance is None else tolerance)


def describe_import(imported: Imported) -> str:
    """Return in words what was imported."""
    model = imported.model
    sizes = []
    for variables, noun in (
        (model.states, "state"),
        (model.actions, "action"),
        (model.observations, "observation"),
    ):
        number = math.prod(v.size for v in variables)
        sizes.append(f"{number} {noun}{'' if number == 1 else 's'}")
    return " ".join(
        [f"{model.format}, {', '.join(sizes)}", *(f"({note.rstrip('.')})" for note in model.notes)]
    )
