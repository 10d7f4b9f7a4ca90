"""From a file in another format to the text of a model in this language."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from hypgen.dsl.diagnostics import Diagnostic, ModelError
from hypgen.dsl.foreign import cassandra, pomdpx
from hypgen.dsl.foreign.formats import recognise
from hypgen.dsl.foreign.model import ForeignModel
from hypgen.dsl.foreign.names import model_name
from hypgen.dsl.foreign.trouble import Trouble
from hypgen.dsl.foreign.writer import write
from hypgen.dsl.source import Source

MAX_BYTES = 32_000_000
MAX_TEXT = 4_000_000  # what a model file of this language may have
_HEAD = 65_536


@dataclass(frozen=True)
class Imported:
    """A foreign model and its text."""

    model: ForeignModel
    text: str


def read(path: str | os.PathLike[str]) -> bytes | None:
    """Return the content of a file in another format, None if it is none; raises ``ModelError``."""
    name = os.fspath(path)
    if not os.path.isfile(name):
        return None  # missing, a folder, or a pipe, which can be read once only
    try:
        with open(name, "rb") as stream:
            head = stream.read(_HEAD)
            if b"\0" in head or recognise(_source(name, head)) is None:
                return None
            content = head + stream.read(MAX_BYTES + 1 - len(head))
    except OSError:
        return None
    if len(content) > MAX_BYTES:
        message = f"'{name}' is larger than {MAX_BYTES // 1_000_000} MB, the most that can be imported"
        remedy = "give what is 0 not at all, and rows that are alike once, with `*`"
        raise ModelError([Diagnostic("E0912", message, None, remedy)])
    return content


def refusal(path: str) -> ModelError:
    """Return what to tell about a file that is in no format known here."""
    message = f"'{path}' is neither in Cassandra's format nor POMDPX"
    remedy = "a model of this language needs no import"
    return ModelError([Diagnostic("E0913", message, None, remedy)])


def import_text(path: str, content: bytes, name: str | None, horizon: int | None) -> Imported:
    """Return the model of a file's content, and its text; raises ``ModelError``.

    ``name`` is the model's (by default the file's), ``horizon`` the most steps of an episode.
    """
    source = _source(path, content)
    found = recognise(source)
    if found is None:  # the beginning alone was readable in another encoding
        raise refusal(path)
    model = (cassandra if found.code == "E0130" else pomdpx).read(source)
    if model.discount == 1 and horizon is None:
        message = "the discount is 1, so that values are sums without end"
        remedy = "give episodes an end: hypgen import FILE --horizon N"
        place = re.search(r"\bdiscount\b", source.text, re.IGNORECASE)
        span = Trouble(source).span(place.start(), 8) if place else found.span
        raise ModelError([Diagnostic("E0908", message, span, remedy)], {path: source})
    text = write(model, name or model_name(Path(path).stem), Path(path).name, horizon)
    if len(text) > MAX_TEXT:
        message = (
            f"as a model of this language the file has {len(text) / 1e6:.1f} MB, more than {MAX_TEXT / 1e6:g}"
        )
        remedy = "make the model smaller"
        raise ModelError([Diagnostic("E0912", message, found.span, remedy)], {path: source})
    return Imported(model, text)


def _source(path: str, content: bytes) -> Source:
    """Return a file's text: names and comments of old files are often in Latin-1."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n"))
