# SPDX-License-Identifier: Apache-2.0
"""Lines as the formatter holds them: which tokens stand in which columns."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from hypgen.dsl.format.tokens import Piece

_TAB = 8


@dataclass
class Line:
    """A line: the tokens ``first .. last - 1``, their columns, and a comment behind them or alone."""

    first: int
    last: int
    columns: list[int] = field(default_factory=list)
    comment: str = ""
    comment_column: int = 0
    blank_before: bool = False

    @property
    def tokens(self) -> range:
        """Return the indexes of the line's tokens."""
        return range(self.first, self.last)


def read_lines(text: str, pieces: list[Piece]) -> list[Line]:
    """Return the lines of a text as the author has them, runs of blank ones noted on the line after."""
    lines: list[Line] = []
    number, offset, blank = 0, 0, False
    for content in text.split("\n"):
        first, end = number, offset
        columns = []
        while number < len(pieces) and pieces[number].start < offset + len(content):
            columns.append(_width(content[: pieces[number].start - offset]))
            end = pieces[number].end
            number += 1
        comment = re.match(r"\s*(#.*?)?\s*$", content[end - offset :])
        assert comment is not None
        at = _width(content[: end - offset + comment.start(1)]) if comment[1] else 0
        if columns or comment[1]:
            lines.append(Line(first, number, columns, comment[1] or "", at, blank and bool(lines)))
        blank = not columns and not comment[1]
        offset += len(content) + 1
    return lines


def _width(text: str) -> int:
    return len(text.expandtabs(_TAB))


def write_lines(lines: list[Line], pieces: list[Piece]) -> str:
    """Return the text of placed lines."""
    result = []
    for line in lines:
        text = ""
        for number, column in zip(line.tokens, line.columns, strict=True):
            text = text.ljust(column) + pieces[number].text
        if line.comment:
            text = text.ljust(line.comment_column) + line.comment
        result.append("\n" * line.blank_before + text + "\n")
    return "".join(result)
