# SPDX-License-Identifier: Apache-2.0
"""Collects the mistakes of a foreign file and cites the places that they are at."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property

from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Source, Span

_MOST = 20


class Trouble:
    """The mistakes of one file."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.found: list[Diagnostic] = []

    def add(self, diagnostic: Diagnostic) -> None:
        """Note a mistake; raises ``ModelError`` when there are many."""
        self.found.append(diagnostic)
        if len(self.found) >= _MOST:
            self.raise_any()

    def stop(self, diagnostic: Diagnostic) -> ModelError:
        """Return the error of a mistake after which nothing more can be read, for the caller to raise."""
        self.found.append(diagnostic)
        return self._error()

    def raise_any(self) -> None:
        """Raise ``ModelError`` if there are mistakes."""
        if self.found:
            raise self._error()

    def span(self, start: int, length: int) -> Span:
        """Return the place of a stretch of a line that starts ``start`` characters into the text."""
        line = bisect_right(self._starts, start)
        column = start - self._starts[line - 1] + 1
        return Span(self.source.name, line, column, line, column + max(length, 1))

    def offset(self, line: int, column: int) -> int:
        """Return how many characters into the text a line (from 1) and column (from 0) are."""
        return min(self._starts[min(line, len(self._starts)) - 1] + column, len(self.source.text))

    @cached_property
    def _starts(self) -> list[int]:
        starts, at = [0], self.source.text.find("\n")
        while at >= 0:
            starts.append(at + 1)
            at = self.source.text.find("\n", at + 1)
        return starts

    def _error(self) -> ModelError:
        def place(d: Diagnostic) -> tuple[int, int]:
            return (d.span.line, d.span.column) if d.span else (0, 0)

        return ModelError(sorted(self.found, key=place), {self.source.name: self.source})
