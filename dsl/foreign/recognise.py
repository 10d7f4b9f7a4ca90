# SPDX-License-Identifier: Apache-2.0
"""Recognises, by content, POMDP files that are in somebody else's format."""

from __future__ import annotations

import re
from itertools import islice

from hypgen.dsl.messages import e01_syntax
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Source, Span

_BLANK = re.compile(r"(?:\s+|#[^\n]*)*")
_CASSANDRA = re.compile(
    r"(discount|values|states|actions|observations|start(?:\s+(?:include|exclude))?|[TOR])\s*:", re.IGNORECASE
)
_OURS = re.compile(r"(?:model|instance|library)\b")
_HEADER = re.compile(r"^(?:discount|values|states|actions|observations)[ \t]*:", re.MULTILINE | re.I)
_ENOUGH_HEADERS = 2  # for a file whose beginning has a slip of the pen
_XML = re.compile(r"<\?xml|<!|<pomdpx", re.IGNORECASE)


def recognise(source: Source) -> Diagnostic | None:
    """Return what to tell the author of a Cassandra or POMDPX file, or None if it may be ours."""
    start = _BLANK.match(source.text).end()  # type: ignore[union-attr]  # matches the empty string too
    if match := _CASSANDRA.match(source.text, start):
        return e01_syntax.cassandra_file(_span(source, match))
    if not _OURS.match(source.text, start):
        headers = list(islice(_HEADER.finditer(source.text), _ENOUGH_HEADERS))
        if len(headers) == _ENOUGH_HEADERS:
            return e01_syntax.cassandra_file(_span(source, headers[0]))
    match = _XML.match(source.text, start)
    if match and "<pomdpx" in source.text[start : start + 4096].lower():
        return e01_syntax.pomdpx_file(_span(source, match))
    if match:
        return e01_syntax.xml_file(_span(source, match))
    return None


def _span(source: Source, match: re.Match[str]) -> Span:
    before = source.text[: match.start()]
    line = before.count("\n") + 1
    column = match.start() - (before.rfind("\n") + 1) + 1
    return Span(source.name, line, column, line, column + len(match.group().split("\n")[0]))
