# SPDX-License-Identifier: Apache-2.0
"""Places of tokens and comments: indentation, columns that stay aligned, comments.

Newlines carry no meaning in the language, so lines are the author's and stay; only columns change. What the
author has aligned with a token of a line above (``else`` under ``then``, one ``=>`` under another) stays so.
"""

from __future__ import annotations

from collections import Counter

from hypgen.dsl.format.alignment import Alignment, Edge, Groups
from hypgen.dsl.format.lines import Line
from hypgen.dsl.format.tokens import CLOSERS, INFIX, OPENERS, Piece

INDENT = 2
_ROUNDS = 100


def place(lines: list[Line], pieces: list[Piece]) -> list[Line]:
    """Return the lines with every token and comment where it belongs."""
    return _Placement(lines, pieces).result()


class _Placement:
    def __init__(self, lines: list[Line], pieces: list[Piece]) -> None:
        self.pieces = pieces
        self.lines = lines
        self.code = [line for line in lines if line.columns]
        self.line_of = {number: at for at, line in enumerate(self.code) for number in line.tokens}
        self.source = [column for line in self.code for column in line.columns]
        self.out = list(self.source)

    def result(self) -> list[Line]:
        groups = Alignment(self.code, self.pieces, self._paragraphs()).groups()
        floors: dict[Edge, int] = {}
        for _ in range(_ROUNDS):
            self._put(groups, floors)
            reached: dict[Edge, int] = {}
            for number, edges in groups.items():
                for group, offset in edges:
                    reached[group] = max(reached.get(group, 0), self.out[number] + offset)
            if reached == floors:
                break
            floors = reached
        else:  # alignments that contradict each other
            self._put({}, {})
        return self._with_comments()

    def _paragraphs(self) -> list[int]:
        """Return for each line of code how many blank lines stand above it."""
        result, count = [], 0
        for line in self.lines:
            count += line.blank_before
            if line.columns:
                result.append(count)
        return result

    # Columns ---------------------------------------------------------------------------------------

    def _put(self, groups: Groups, floors: dict[Edge, int]) -> None:
        """Place all tokens, the edges of a group no further left than its floor."""
        for line in self.code:
            self.out[line.first] = self._indent(line.first)
            for number in line.tokens[1:]:
                column = self._end(number - 1) + self.pieces[number].gap
                for group, offset in groups.get(number, ()):
                    column = max(column, floors.get(group, 0) - offset)
                self.out[number] = column

    def _end(self, number: int) -> int:
        return self.out[number] + len(self.pieces[number].text)

    def _indent(self, number: int) -> int:
        """Return the column of a token that starts a line; those of the lines above are known."""
        piece = self.pieces[number]
        if piece.opener >= 0 and (piece.text in CLOSERS or piece.element or piece.kind):
            opening = self.code[self.line_of[piece.opener]]
            inside = piece.opener + 1
            if piece.text in CLOSERS:
                return self.out[opening.first]
            if inside < opening.last and self.source[inside] == self.source[number]:
                return self.out[inside]
            return self.out[opening.first] + INDENT
        if piece.kind:
            return 0
        return self._continuation(number)

    def _continuation(self, number: int) -> int:
        """Return the column of a line that goes on with a statement: under what it was aligned with."""
        piece = self.pieces[number]
        start = self.line_of[piece.statement]
        base = self.code[max(start, self._element_line(number))].first
        offset = self.source[number] - self.source[base]
        if offset <= 2 * INDENT:
            return self.out[base] + (INDENT if offset < 2 * INDENT else offset)
        for line in reversed(self.code[start : self.line_of[number]]):
            anchor = self._token_at(line, self.source[number])
            if anchor is not None:
                return self.out[anchor]
            following = number + 1
            if (
                piece.text in INFIX
                and following in self.line_of
                and self.line_of[following] == self.line_of[number]
            ):
                anchor = self._token_at(line, self.source[following])
                reach = self.source[following] - self.source[number]
                if anchor is not None and self.out[anchor] >= reach == len(piece.text) + 1:
                    return self.out[anchor] - reach
        return self.out[base] + 2 * INDENT

    def _element_line(self, number: int) -> int:
        """Return the line in which the token's element of its bracket starts, 0 outside brackets."""
        opener = self.pieces[number].opener
        while opener >= 0 and number > opener:
            number -= 1
            if self.pieces[number].opener == opener and self.pieces[number].element:
                return self.line_of[number]
        return 0

    def _token_at(self, line: Line, column: int) -> int | None:
        """Return the line's token at a column of the source, if it is one to align with."""
        for number, at in zip(line.tokens, line.columns, strict=True):
            if at == column and (
                number == line.first or self.pieces[number].gap or self.pieces[number].element
            ):
                return number
        return None

    # Comments ---------------------------------------------------------------------------------------

    def _with_comments(self) -> list[Line]:
        result: list[Line] = []
        for at, line in enumerate(self.lines):
            columns = [self.out[number] for number in line.tokens]
            column = 0
            if line.comment and not line.columns:
                column = self._own_line(at, result)
            elif line.comment:
                column = max(self._comment_column(at), self._end(line.last - 1) + 2)
            blank = line.blank_before and not self._at_edge(at)
            result.append(Line(line.first, line.last, columns, line.comment, column, blank))
        return result

    def _at_edge(self, at: int) -> bool:
        """Return whether a line follows an opening bracket or starts with a closing one."""
        above, line = self.lines[at - 1], self.lines[at]
        opened = above.columns and self.pieces[above.last - 1].text in OPENERS
        return bool(opened or (line.columns and self.pieces[line.first].text in CLOSERS))

    def _own_line(self, at: int, placed: list[Line]) -> int:
        """Return the column of a comment on a line of its own: that of the code below it, usually."""
        line = self.lines[at]
        above = self.lines[at - 1] if at else None
        if above is not None and above.comment and not line.blank_before:
            continued = above.columns or placed[-1].comment_column > self._below(at)
            if continued and above.comment_column == line.comment_column:
                return placed[-1].comment_column
        return self._below(at)

    def _below(self, at: int) -> int:
        below = next((line for line in self.lines[at:] if line.columns), None)
        if below is None:
            return 0
        closing = self.pieces[below.first].text in CLOSERS
        return self.out[below.first] + (INDENT if closing else 0)

    def _comment_column(self, at: int) -> int:
        """Return where the comments of the lines around this one stand, or else this one itself."""
        first = last = at
        while first and self._has_both(first - 1) and not self.lines[first].blank_before:
            first -= 1
        while (
            last + 1 < len(self.lines) and self._has_both(last + 1) and not self.lines[last + 1].blank_before
        ):
            last += 1
        counts = Counter(line.comment_column for line in self.lines[first : last + 1])
        column, count = max(counts.items(), key=lambda item: (item[1], item[0]))
        return column if count > 1 else self.lines[at].comment_column

    def _has_both(self, at: int) -> bool:
        return bool(self.lines[at].columns and self.lines[at].comment)
