# SPDX-License-Identifier: Apache-2.0
"""The one renderer of diagnostics: plain text with a framed excerpt, or data."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping
from typing import Any

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Source, Span

_WIDTH = 100
_MOST = 50
_TAB = "    "
_ELLIPSIS = "..."


def render(diagnostic: Diagnostic, sources: Mapping[str, Source]) -> str:
    """Return a diagnostic as text: message, place, excerpt with carets, notes and remedy."""
    lines = [f"{diagnostic.severity}[{diagnostic.code}]: {diagnostic.message}"]
    spans = [s for s in (diagnostic.span, *(span for span, _ in diagnostic.notes)) if s is not None]
    gutter = max((len(str(s.line)) for s in spans), default=1)
    if diagnostic.span is not None:
        lines += _excerpt(diagnostic.span, sources, gutter)
    for span, text in diagnostic.notes:
        lines += [f"note: {text}", *_excerpt(span, sources, gutter)]
    lines.append(f"help: {diagnostic.remedy}")
    return "\n".join(lines) + "\n"


def render_all(diagnostics: Iterable[Diagnostic], sources: Mapping[str, Source]) -> str:
    """Return several diagnostics as text, a blank line between them; of very many the first ones."""
    found = list(diagnostics)
    shown = [render(d, sources) for d in found[:_MOST]]
    if len(found) > _MOST:
        shown.append(f"and {len(found) - _MOST} more\n")
    return "\n".join(shown)


def render_line(diagnostic: Diagnostic) -> str:
    """Return a diagnostic as one line: place, code and message."""
    span = diagnostic.span
    place = "" if span is None else f"{span.file}:{span.line}:{span.column}: "
    return f"{place}{diagnostic.severity}[{diagnostic.code}]: {diagnostic.message}"


def to_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """Return a diagnostic as plain data."""
    return {
        "severity": diagnostic.severity,
        "code": diagnostic.code,
        "message": diagnostic.message,
        "span": _span_data(diagnostic.span),
        "remedy": diagnostic.remedy,
        "notes": [{"span": _span_data(span), "text": text} for span, text in diagnostic.notes],
    }


def _span_data(span: Span | None) -> dict[str, Any] | None:
    if span is None:
        return None
    return {
        "file": span.file,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
    }


def _excerpt(span: Span, sources: Mapping[str, Source], gutter: int) -> list[str]:
    margin = " " * gutter
    place = [f"{margin}--> {span.file}:{span.line}:{span.column}"]
    source = sources.get(span.file)
    if source is None:
        return place
    text = source.line(span.line)
    start = min(span.column - 1, len(text))
    # Of a span over several lines the first is shown.
    end = span.end_column - 1 if span.end_line == span.line else len(text.rstrip())
    before, marked, after = _display(text[:start]), _display(text[start:end]), _display(text[end:])
    before, marked, after = _crop(before, marked, after)
    carets = "^" * max(1, _cells(marked))
    return [
        *place,
        f"{margin} |",
        f"{span.line:>{gutter}} | {before}{marked}{after}".rstrip(),
        f"{margin} | {' ' * _cells(before)}{carets}",
    ]


def _display(text: str) -> str:
    """Return text as it can be printed on one line: no tabs and no control characters."""
    return "".join(_TAB if c == "\t" else c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _cells(text: str) -> int:
    """Return how many columns a terminal gives the text."""
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text
    )


def _crop(before: str, marked: str, after: str) -> tuple[str, str, str]:
    """Shorten a long line to what stands around the marked part."""
    if len(before) + len(marked) + len(after) <= _WIDTH:
        return before, marked, after
    if len(marked) > _WIDTH // 2:
        marked = marked[: _WIDTH // 2]
        after = ""
        tail = _ELLIPSIS
    else:
        tail = ""
    room = _WIDTH - len(marked)
    left = max(room // 2, room - len(after))
    if len(before) > left:
        before = _ELLIPSIS + before[len(before) - left + len(_ELLIPSIS) :]
    right = room - len(before)
    if len(after) > right:
        after = after[: right - len(_ELLIPSIS)]
        tail = _ELLIPSIS
    return before, marked, after + tail
