# SPDX-License-Identifier: Apache-2.0
"""Source text and positions in it."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True)
class Source:
    """A model's text and the name under which messages cite it (a path as the user gave it)."""

    name: str
    text: str

    def line(self, number: int) -> str:
        """Return line ``number`` (from 1) without its end; empty past the end of the text."""
        return self._lines[number - 1].rstrip("\r") if 1 <= number <= len(self._lines) else ""

    def without(self, spans: Iterable[Span]) -> str:
        """Return the text without some stretches of it and the blanks and empty lines before each."""
        lines, kept, done = self.text.split("\n"), [], 0
        starts = [0, *itertools.accumulate(len(line) + 1 for line in lines)]
        for span in sorted(s for s in spans if s.file == self.name):
            kept.append(self.text[done : starts[span.line - 1] + span.column - 1].rstrip())
            done = starts[span.end_line - 1] + span.end_column - 1
        return "".join((*kept, self.text[done:]))

    @cached_property
    def _lines(self) -> list[str]:
        return self.text.split("\n")


@dataclass(frozen=True, order=True)
class Span:
    """A stretch of source: lines and columns count from 1, ``end_column`` is exclusive."""

    file: str
    line: int
    column: int
    end_line: int
    end_column: int

    def contains(self, other: Span) -> bool:
        """Return whether ``other`` lies within this span."""
        ends = (other.end_line, other.end_column) <= (self.end_line, self.end_column)
        return self.file == other.file and (self.line, self.column) <= (other.line, other.column) and ends

    def to(self, other: Span) -> Span:
        """Return the span from the start of this one to the end of ``other``."""
        return Span(self.file, self.line, self.column, other.end_line, other.end_column)
