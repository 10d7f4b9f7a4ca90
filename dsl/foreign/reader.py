# SPDX-License-Identifier: Apache-2.0
"""From a file in another format to the text of a model in this language."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from hypgen.dsl.foreign.cassandra import read_cassandra
from hypgen.dsl.foreign.files import refusal, source_of
from hypgen.dsl.foreign.pomdpx import read_pomdpx
from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.foreign.tables.foreign_model import ForeignModel
from hypgen.dsl.foreign.tables.names import model_name
from hypgen.dsl.foreign.tables.rows import TOLERANCE
from hypgen.dsl.foreign.writer.shortest_path import shortest_paths
from hypgen.dsl.foreign.writer.write import write
from hypgen.dsl.messages import e01_syntax, e09_other_formats
from hypgen.dsl.messages.diagnostic import ModelError

MAX_TEXT = 16_000_000  # what a model file of this language may have


@dataclass(frozen=True)
class Imported:
    """A foreign model and its text."""

    model: ForeignModel
    text: str


def import_text(
    path: str, content: bytes, name: str | None, horizon: int | None, tolerance: float = TOLERANCE
) -> Imported:
    """Return the model of a file's content, and its text; raises ``ModelError``.

    ``name`` is the model's (by default the file's), ``horizon`` the most steps of an episode. Rows that
    are off 1 by at most ``tolerance`` are scaled.
    """
    source = source_of(path, content)
    found = recognise(source)
    if found is None:  # the beginning alone was readable in another encoding
        raise refusal(path)
    model = (read_cassandra if found.code == e01_syntax.CASSANDRA else read_pomdpx).read(source, tolerance)
    paths = shortest_paths(model) if model.discount == 1 and horizon is None else None
    if isinstance(paths, str):
        limited = shlex.quote(f"{Path(path).stem}_100.pomdp")
        place = model.discount_place
        endless = e09_other_formats.endless_sums if place else e09_other_formats.no_discount
        raise ModelError([endless(paths, shlex.quote(path), limited, place or found.span)], {path: source})
    text = write(model, name or model_name(Path(path).stem), Path(path).name, horizon, paths)
    if len(text) > MAX_TEXT:
        raise ModelError([e09_other_formats.large_model(len(text), MAX_TEXT, found.span)], {path: source})
    return Imported(model, text)
