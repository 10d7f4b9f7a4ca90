# SPDX-License-Identifier: Apache-2.0
"""Quick fixes: what remedies quote, tried on the text, and offered where the front end finds less wrong.

No table of codes is needed, so a new message with a remedy has its fix by itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.editor.document import Document

_QUOTED = re.compile(r"`([^`]+)`|'([^']+)'")
_LAST_NAME = re.compile(r"(?<=\.)\w+$")
_MOST = 12  # texts that are tried for one mistake


@dataclass(frozen=True)
class Fix:
    """A text in the place of that between two offsets."""

    title: str
    start: int
    end: int
    text: str


def fixes(document: Document, mistake: Diagnostic) -> list[Fix]:
    """Return the best change that takes a mistake away and brings no other, or nothing."""
    if mistake.span is None or mistake.span.file != document.path:
        return []
    before = {(d.code, d.message) for d in document.current().found}
    for number, fix in enumerate(_candidates(document.text, mistake)):
        if number == _MOST:
            break
        after = document.text[: fix.start] + fix.text + document.text[fix.end :]
        if {(d.code, d.message) for d in document.diagnostics_of(after)} < before:
            return [fix]
    return []


def _candidates(text: str, mistake: Diagnostic) -> Iterator[Fix]:
    assert mistake.span is not None
    start = offset_of(text, mistake.span.line, mistake.span.column)
    end = offset_of(text, mistake.span.end_line, mistake.span.end_column)
    places = [(offset_of(text, s.line, s.column), note) for s, note in mistake.notes]
    line_end = text.find("\n", end) if "\n" in text[end:] else len(text)
    for match in _QUOTED.finditer(mistake.remedy):
        quoted = match[1] or match[2]
        yield Fix(f"Write {quoted}", start, end, quoted)
        if last := _LAST_NAME.search(text[:end], start):  # of a member, such as `room.tigr`
            yield Fix(f"Write {quoted}", last.start(), end, quoted)
        for at, _ in places:
            yield Fix(f"Insert {quoted}", at, at, f"{quoted}\n" if quoted == "}" else quoted)
        yield Fix(f"Insert {quoted}", start, start, f"{quoted} ")
        yield Fix(f"Insert {quoted}", end, end, f" {quoted}")
        yield Fix(f"Insert {quoted}", line_end, line_end, f"\n{quoted}")
    line_start = text.rfind("\n", 0, start) + 1
    for old, new in (("=", "~"), ("~", "=")):
        for sign in re.finditer(rf"(?<![=<>!]){old}(?![=>])", text[line_start:line_end]):
            at = line_start + sign.start()
            yield Fix(f"Write {new} for {old}", at, at + 1, new)


def offset_of(text: str, line: int, column: int) -> int:
    """Return the offset of a line and column, which count from 1."""
    start = 0
    for _ in range(line - 1):
        found = text.find("\n", start)
        if found < 0:
            return len(text)
        start = found + 1
    return min(start + column - 1, len(text))
