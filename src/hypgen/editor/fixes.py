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
_AROUND = re.compile(r"\b(\w+)\(\.\.\)")
_ADDED = re.compile(r"add: (init )?(\w+)('?) = \.\.")
_LEFT_OUT = re.compile(r"'match' leaves out (.+)")
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
    yield from _filled(text, start, end, line_end, mistake)
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


def _filled(text: str, start: int, end: int, line_end: int, mistake: Diagnostic) -> Iterator[Fix]:
    """Yield the remedies that hold ``..``, with what stands in the text already in its place."""
    wrong = text[start:end]
    for call in _AROUND.findall(mistake.remedy):
        yield Fix(f"Write {call}({wrong})", start, end, f"{call}({wrong})")
    if added := _ADDED.search(mistake.remedy):
        init, name, prime = added.groups()
        typed = wrong.partition(":")[2].strip()
        form = f"init {name} ~ uniform({typed})" if init else f"{name}{prime} = {name}"
        indent = re.match(r"\s*", text[text.rfind("\n", 0, start) + 1 : start])
        yield Fix(f"Add {form}", line_end, line_end, f"\n{indent[0] if indent else ''}{form}")
    if left_out := _LEFT_OUT.fullmatch(mistake.message):
        last = re.search(r"([ \t]*)\S.*?=>(.*)\s*\}$", wrong)
        if last is not None:
            value, names = last[2].strip(), left_out[1].split(", ")
            lines = "".join(f"{last[1]}{name} => {value}\n" for name in names)
            yield Fix(f"Add {left_out[1]} with the value {value}", end - 1, end - 1, lines)


def offset_of(text: str, line: int, column: int) -> int:
    """Return the offset of a line and column, which count from 1."""
    start = 0
    for _ in range(line - 1):
        found = text.find("\n", start)
        if found < 0:
            return len(text)
        start = found + 1
    return min(start + column - 1, len(text))
