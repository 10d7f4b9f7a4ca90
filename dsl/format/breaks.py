# SPDX-License-Identifier: Apache-2.0
"""Breaks lines that are too long: after a comma or a sign, before an operator, as far out as possible."""

from __future__ import annotations

from dataclasses import replace

from hypgen.dsl.format.layout import INDENT
from hypgen.dsl.format.lines import Line
from hypgen.dsl.format.tokens import CLAUSES, CLOSERS, Piece

WIDTH = 100

_AFTER = {",": 10, "=": 5, "~": 5, "=>": 5, ":": 8}
_BEFORE = {
    "else": 8,
    "then": 9,
    "where": 14,
    "or": 10,
    "and": 12,
    **dict.fromkeys(("+", "-"), 20),
    **dict.fromkeys(("==", "!=", "<", "<=", ">", ">="), 30),
    **dict.fromkeys(("*", "/", "//", "%"), 40),
}
_ARM = 0
_DEPTH = 15  # what a bracket or a conditional around the break costs
_TOO_LONG = 50  # what it costs if the rest does not fit either
_BRANCH_TOO_LONG = 10  # the same where a branch starts, which can be broken once more
_SHORT = 30  # what it costs to leave less than a third of the line above


def break_long_lines(lines: list[Line], pieces: list[Piece]) -> list[Line]:
    """Return the lines with each that is too long broken once, where that can be done.

    Items start lines, and so do members and closing braces where the opening brace ends a line.
    """
    result = []
    at_end = {line.last - 1 for line in lines}
    for number, line in enumerate(lines):
        closing = (n for n in line.tokens[1:] if pieces[n].text == "}" and pieces[n].opener in at_end)
        brace = next(closing, None)
        above = lines[:number] if _too_long(line, pieces) else []
        result += _broken(line, pieces, at_end, above) if brace is None else _split(line, brace, 0)
    return result


def _broken(line: Line, pieces: list[Piece], at_end: set[int], above: list[Line]) -> list[Line]:
    for at in line.tokens[1:]:
        statement = pieces[at].kind and pieces[at].kind not in CLAUSES
        if statement and (pieces[at].opener < 0 or pieces[at].opener in at_end or _too_long(line, pieces)):
            return _split(line, at, _column(line, at, pieces, above))
    if not _too_long(line, pieces):
        return [line]
    costs = [(_cost(line, at, pieces, above), -at) for at in line.tokens[1:]]
    choices = [(cost, at) for cost, at in costs if cost is not None]
    if not choices:
        return [line]
    at = -min(choices)[1]
    return _split(line, at, _column(line, at, pieces, above))


def _too_long(line: Line, pieces: list[Piece]) -> bool:
    return bool(line.columns) and line.columns[-1] + len(pieces[line.last - 1].text) > WIDTH


def _split(line: Line, at: int, column: int) -> list[Line]:
    count = at - line.first
    shift = column - line.columns[count]
    above = replace(line, last=at, columns=line.columns[:count], comment="")
    below = Line(
        at,
        line.last,
        [column + shift for column in line.columns[count:]],
        line.comment,
        max(0, line.comment_column + shift),
    )
    return [above, below]


def _cost(line: Line, at: int, pieces: list[Piece], above: list[Line]) -> int | None:
    """Return how bad it is to start a line at a token, None where that may not be."""
    before = line.columns[at - line.first - 1] + len(pieces[at - 1].text)
    cost = _own_cost(at, pieces)
    if cost is None or before > WIDTH:
        return None
    cost += _DEPTH * pieces[at].nested + _place_in_chain(at, pieces)
    opener = pieces[at].opener
    while opener >= line.first:
        cost += _DEPTH
        opener = pieces[opener].opener
    branch = pieces[at].partner >= 0
    if _column(line, at, pieces, above) + _rest(line, at, pieces) > WIDTH:
        cost += _BRANCH_TOO_LONG if branch else _TOO_LONG
    if before - line.columns[0] < WIDTH // 3 and not branch:
        cost += _SHORT
    return cost


def _place_in_chain(at: int, pieces: list[Piece]) -> int:
    """Return how many cases come before a branch, so that a chain is broken at the first ``else``."""
    count, number = 0, _else_before(at, pieces) if pieces[at].partner >= 0 else None
    while number is not None:
        count, number = count + 1, _else_before(number, pieces)
    return count


def _own_cost(at: int, pieces: list[Piece]) -> int | None:
    piece, before = pieces[at], pieces[at - 1].text
    if not piece.gap or piece.text in CLOSERS:
        return None
    if piece.kind == "arm" and piece.opener != at - 1:
        return _ARM
    if before == ":":  # of a quantifier or a comprehension, whose bracket starts with `name in`
        return _AFTER[before] if piece.opener >= 0 and pieces[piece.opener + 2].text == "in" else None
    if before in _AFTER:
        return _AFTER[before]
    if piece.text == "-" and not pieces[at + 1].gap:
        return None  # a sign
    return _BEFORE.get(piece.text)


def _column(line: Line, at: int, pieces: list[Piece], above: list[Line]) -> int:
    """Return where a token goes that starts a line: behind its bracket if there is room for the rest."""
    opener = pieces[at].opener
    if pieces[at].kind and opener < 0:
        return 0
    if pieces[at].partner >= 0:
        return _of_branch(line, at, pieces, above)
    if opener >= line.first and opener != at - 1:
        inside = line.columns[opener + 1 - line.first]
        if inside + _rest(line, at, pieces) <= WIDTH:
            return inside
    if opener < line.first and (pieces[at].kind or not pieces[line.first].kind):
        return line.columns[0]
    return line.columns[0] + (INDENT if pieces[at - 1].role == "sign" else 2 * INDENT)


def _of_branch(line: Line, at: int, pieces: list[Piece], above: list[Line]) -> int:
    """Return the column of a ``then`` or ``else``: under its partner, or as that one's line goes on."""
    partner, before = pieces[at].partner, _else_before(at, pieces)
    lines = (line, *reversed(above))
    owner = next(other for other in lines if partner in other.tokens)
    column = owner.columns[partner - owner.first]
    chain = [other for other in lines if before == other.first and before + 1 in other.tokens]
    if chain:
        return chain[0].columns[0]
    if partner == owner.first:
        return column
    if pieces[at].text == "else" and column <= WIDTH // 2 and column + _rest(line, at, pieces) <= WIDTH:
        return column
    deeper = pieces[owner.first].kind or pieces[at].nested > pieces[owner.first].nested
    return owner.columns[0] + 2 * INDENT * bool(deeper)


def _else_before(at: int, pieces: list[Piece]) -> int | None:
    """Return the ``else`` of the chain ``else if .. then .. else`` that goes on with this branch."""
    then = pieces[at].partner if pieces[at].text == "else" else at
    before = pieces[then].partner - 1
    return before if pieces[before].text == "else" and pieces[before].partner >= 0 else None


def _rest(line: Line, at: int, pieces: list[Piece]) -> int:
    """Return the width of what follows, up to where a line can be broken at least as well."""
    last = at
    while last + 1 < line.last and not _goes_out(at, last + 1, pieces):
        last += 1
    return line.columns[last - line.first] + len(pieces[last].text) - line.columns[at - line.first]


def _goes_out(at: int, number: int, pieces: list[Piece]) -> bool:
    """Return whether a token goes on with the conditional of the token ``at``, or with an outer one."""
    piece, depth = pieces[number], pieces[at].nested
    if piece.partner < 0:
        return False
    return piece.nested <= depth if piece.text == "else" else piece.nested < depth
