# SPDX-License-Identifier: Apache-2.0
"""Tokens of different lines that the author has aligned with each other, and that stay so."""

from __future__ import annotations

from collections.abc import Iterator

from hypgen.dsl.format.lines import Line
from hypgen.dsl.format.tokens import Piece

_SAME_COLUMN = 8  # signs further apart than this were not meant to be aligned

Edge = tuple[int, int]  # a token's start, or its end that is so many columns further
Groups = dict[int, list[tuple[Edge, int]]]  # by token: what its edges are aligned with, and their offsets


class Alignment:
    """Finds what is aligned: ``paragraphs`` counts for each line of code the blank lines above it."""

    def __init__(self, code: list[Line], pieces: list[Piece], paragraphs: list[int]) -> None:
        self.pieces = pieces
        self.code = code
        self.apart = paragraphs
        self.line_of = {number: at for at, line in enumerate(code) for number in line.tokens}

    def groups(self) -> Groups:
        """Return the groups of every token that is aligned with one of another line."""
        columns = [column for line in self.code for column in line.columns]
        siblings = list(self._siblings())
        self._mend_signs(columns, siblings)
        root: dict[Edge, Edge] = {}

        def find(edge: Edge) -> Edge:
            while root.setdefault(edge, edge) != edge:
                edge = root[edge]
            return edge

        neighbours = [(a, a + 1) for a in range(len(self.code) - 1) if self.apart[a] == self.apart[a + 1]]
        first_lines = [(self.line_of[a], self.line_of[b]) for run in siblings for a, b in _pairs(run)]
        for a, b in {*neighbours, *first_lines}:
            for one, other in self._aligned(self.code[a], self.code[b], columns):
                root[find(one)] = find(other)
        groups: Groups = {}
        for number, offset in list(root):
            groups.setdefault(number, []).append((find((number, offset)), offset))
        return groups

    def _aligned(self, above: Line, below: Line, columns: list[int]) -> Iterator[tuple[Edge, Edge]]:
        """Yield the edges of two lines that stand in one column, where it took more than the usual space."""
        places = {columns[number]: number for number in above.tokens[1:]}
        for other in below.tokens[1:]:
            one = places.get(columns[other])
            if one is None or self.pieces[one].role != self.pieces[other].role:
                continue
            spaced = self.pieces[one].gap and self.pieces[other].gap
            if spaced and (self._wide(one, columns) or self._wide(other, columns)):
                yield (one, 0), (other, 0)
        ends = {columns[one] + width: (one, width) for one, width in self._numbers(above)}
        for other, width in self._numbers(below):
            edge = ends.get(columns[other] + width)
            if edge is not None and (self._wide(edge[0], columns) or self._wide(other, columns)):
                yield edge, (other, width)

    def _numbers(self, line: Line) -> Iterator[tuple[int, int]]:
        """Yield the numbers in a line's lists, with their signs: the first token and the width."""
        for number in line.tokens[1:]:
            piece = self.pieces[number]
            if not piece.text[0].isdigit() or piece.opener < 0 or self.pieces[piece.opener].text != "[":
                continue
            signed = self.pieces[number - 1].text == "-" and not piece.gap
            if number - signed > line.first:
                yield number - signed, len(piece.text) + signed

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


def _pairs(run: list[int]) -> Iterator[tuple[int, int]]:
    return zip(run, run[1:], strict=False)
