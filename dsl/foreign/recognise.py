"""Recognises, by content, POMDP files that are in somebody else's format."""

from __future__ import annotations

import re

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Source, Span

_BLANK = re.compile(r"(?:\s+|#[^\n]*)*")
_CASSANDRA = re.compile(
    r"(discount|values|states|actions|observations|start(?:\s+(?:include|exclude))?|[TOR])\s*:", re.IGNORECASE
)
_XML = re.compile(r"<\?xml|<!|<pomdpx", re.IGNORECASE)

_REMEDY = (
    "`hypgen import FILE -o NEW.pomdp` writes it as a model of this language; "
    "run, sim, compile and the like take the file as it is"
)


def recognise(source: Source) -> Diagnostic | None:
    """Return what to tell the author of a Cassandra or POMDPX file, or None if it may be ours."""
    start = _BLANK.match(source.text).end()  # type: ignore[union-attr]  # matches the empty string too
    if match := _CASSANDRA.match(source.text, start):
        message = "this is a file in Cassandra's POMDP format (flat lists of states and numbers)"
        return Diagnostic("E0130", message, _span(source, match), _REMEDY)
    match = _XML.match(source.text, start)
    if match and "<pomdpx" in source.text[start : start + 4096].lower():
        return Diagnostic("E0131", "this is a POMDPX file (XML)", _span(source, match), _REMEDY)
    if match:
        return Diagnostic("E0131", "this is an XML file, perhaps POMDPX", _span(source, match), _REMEDY)
    return None


def _span(source: Source, match: re.Match[str]) -> Span:
    before = source.text[: match.start()]
    line = before.count("\n") + 1
    column = match.start() - (before.rfind("\n") + 1) + 1
    return Span(source.name, line, column, line, column + len(match.group().split("\n")[0]))
