"""Where the formatter puts tokens and comments: indentation, columns that stay aligned, comments.

Newlines carry no meaning in the language, so lines are the author's and stay; only columns change. What the
author has aligned with a token of a line above (``else`` under ``then``, one ``=>`` under another) stays so.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from hypgen.dsl.format_tokens import CLOSERS, INFIX, OPENERS, Piece

INDENT = 2
_TAB = 8
_ROUNDS = 100
_SAME_COLUMN = 8  # signs further apart than this were not meant to be aligned


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
        self.apart = self._paragraphs()
        self.out = list(self.source)

    def result(self) -> list[Line]:
        groups = self._groups()
        floors: dict[int, int] = {}
        for _ in range(_ROUNDS):
            self._put(groups, floors)
            reached: dict[int, int] = {}
            for number, group in groups.items():
                reached[group] = max(reached.get(group, 0), self.out[number])
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

    def _put(self, groups: dict[int, int], floors: dict[int, int]) -> None:
        """Place all tokens, those of a group no further left than its floor."""
        for line in self.code:
            self.out[line.first] = self._indent(line.first)
            for number in line.tokens[1:]:
                column = self._end(number - 1) + self.pieces[number].gap
                if number in groups:
                    column = max(column, floors.get(groups[number], 0))
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

    # Alignment --------------------------------------------------------------------------------------

    def _groups(self) -> dict[int, int]:
        """Return the group of every token that is aligned with one of another line."""
        columns = list(self.source)
        siblings = list(self._siblings())
        self._mend_signs(columns, siblings)
        root: dict[int, int] = {}

        def find(number: int) -> int:
            while root.setdefault(number, number) != number:
                number = root[number]
            return number

        neighbours = [(a, a + 1) for a in range(len(self.code) - 1) if self.apart[a] == self.apart[a + 1]]
        first_lines = [(self.line_of[a], self.line_of[b]) for run in siblings for a, b in _pairs(run)]
        for a, b in {*neighbours, *first_lines}:
            for one, other in self._aligned(self.code[a], self.code[b], columns):
                root[find(one)] = find(other)
        return {number: find(number) for number in list(root)}

    def _aligned(self, above: Line, below: Line, columns: list[int]) -> Iterator[tuple[int, int]]:
        """Yield the tokens of two lines that stand in one column, where it took more than the usual space."""
        places = {columns[number]: number for number in above.tokens[1:]}
        for other in below.tokens[1:]:
            one = places.get(columns[other])
            if one is None or self.pieces[one].role != self.pieces[other].role:
                continue
            if (
                self.pieces[one].gap
                and self.pieces[other].gap
                and (self._wide(one, columns) or self._wide(other, columns))
            ):
                yield one, other

    def _wide(self, number: int, columns: list[int]) -> bool:
        gap = columns[number] - columns[number - 1] - len(self.pieces[number - 1].text)
        return gap > self.pieces[number].gap

    def _siblings(self) -> Iterator[list[int]]:
        """Yield the runs of like statements, each on lines of its own and with no blank line between."""
        runs: dict[int, list[int]] = {}
        for line in self.code:
            piece = self.pieces[line.first]
            if not piece.kind:
                continue
            run = runs.setdefault(piece.opener, [])
            if run and (
                self.pieces[run[-1]].kind != piece.kind
                or self.apart[self.line_of[run[-1]]] != self.apart[self.line_of[line.first]]
            ):
                yield run
                run = runs[piece.opener] = []
            run.append(line.first)
        yield from runs.values()

    def _mend_signs(self, columns: list[int], siblings: list[list[int]]) -> None:
        """Where a run has its signs aligned but for a few, count these as aligned too."""
        for run in siblings:
            signs = [sign for sign in map(self._sign, run) if sign is not None]
            agreed = {
                columns[a]
                for a, b in _pairs(signs)
                if columns[a] == columns[b] and (self._wide(a, columns) or self._wide(b, columns))
            }
            if len(agreed) != 1:
                continue
            column = agreed.pop()
            members = [sign for sign in signs if abs(columns[sign] - column) <= _SAME_COLUMN]
            column = max(columns[sign] for sign in members)
            for sign in members:
                shift = column - columns[sign]
                for number in range(sign, self.code[self.line_of[sign]].last):
                    columns[number] += shift

    def _sign(self, statement: int) -> int | None:
        """Return the statement's ``=``, ``~`` or ``=>`` (an enum's brace) if it stands on the first line."""
        wanted = "{" if self.pieces[statement].kind == "enum" else "sign"
        for number in range(statement, self.code[self.line_of[statement]].last):
            if self.pieces[number].role == wanted and self.pieces[number].statement == statement:
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


def _pairs(run: list[int]) -> Iterator[tuple[int, int]]:
    return zip(run, run[1:], strict=False)
