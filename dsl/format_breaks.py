"""Breaks lines that are too long: after a comma or a sign, before an operator, as far out as possible."""

from __future__ import annotations

from dataclasses import replace

from hypgen.dsl.format_layout import INDENT
from hypgen.dsl.format_lines import Line
from hypgen.dsl.format_tokens import CLAUSES, CLOSERS, Piece

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
_DEPTH = 15  # what a bracket around the break costs
_TOO_LONG = 50  # what it costs if the rest does not fit either
_SHORT = 30  # what it costs to leave less than a third of the line above


def break_long_lines(lines: list[Line], pieces: list[Piece]) -> list[Line]:
    """Return the lines with each that is too long broken once, where that can be done.

    Items start lines, and so do members and closing braces where the opening brace ends a line.
    """
    result = []
    at_end = {line.last - 1 for line in lines}
    for line in lines:
        closing = (n for n in line.tokens[1:] if pieces[n].text == "}" and pieces[n].opener in at_end)
        brace = next(closing, None)
        result += _broken(line, pieces, at_end) if brace is None else _split(line, brace, 0)
    return result


def _broken(line: Line, pieces: list[Piece], at_end: set[int]) -> list[Line]:
    for at in line.tokens[1:]:
        statement = pieces[at].kind and pieces[at].kind not in CLAUSES
        if statement and (pieces[at].opener < 0 or pieces[at].opener in at_end or _too_long(line, pieces)):
            return _split(line, at, _column(line, at, pieces))
    if not _too_long(line, pieces):
        return [line]
    choices = [(cost, -at) for at in line.tokens[1:] if (cost := _cost(line, at, pieces)) is not None]
    if not choices:
        return [line]
    at = -min(choices)[1]
    return _split(line, at, _column(line, at, pieces))


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


def _cost(line: Line, at: int, pieces: list[Piece]) -> int | None:
    """Return how bad it is to start a line at a token, None where that may not be."""
    before = line.columns[at - line.first - 1] + len(pieces[at - 1].text)
    cost = _own_cost(at, pieces)
    if cost is None or before > WIDTH:
        return None
    opener = pieces[at].opener
    while opener >= line.first:
        cost += _DEPTH
        opener = pieces[opener].opener
    if _column(line, at, pieces) + _rest(line, at, pieces) > WIDTH:
        cost += _TOO_LONG
    if before - line.columns[0] < WIDTH // 3:
        cost += _SHORT
    return cost


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


def _column(line: Line, at: int, pieces: list[Piece]) -> int:
    """Return where a token goes that starts a line: behind its bracket if there is room for the rest."""
    opener = pieces[at].opener
    if pieces[at].kind and opener < 0:
        return 0
    then = _then(line, at, pieces)
    if then is not None and then + _rest(line, at, pieces) <= WIDTH:
        return then
    if opener >= line.first and opener != at - 1:
        inside = line.columns[opener + 1 - line.first]
        if inside + _rest(line, at, pieces) <= WIDTH:
            return inside
    if opener < line.first and (pieces[at].kind or not pieces[line.first].kind):
        return line.columns[0]
    return line.columns[0] + (INDENT if pieces[at - 1].role == "sign" else 2 * INDENT)


def _then(line: Line, at: int, pieces: list[Piece]) -> int | None:
    """Return the column of the ``then`` on the line that an ``else`` belongs to."""
    nested = 0
    for number in range(at, line.first, -1):
        if pieces[number].opener == pieces[at].opener and pieces[number].text in ("then", "else"):
            nested += 1 if pieces[number].text == "else" else -1
            if nested <= 0:
                return line.columns[number - line.first] if number < at else None
    return None


def _rest(line: Line, at: int, pieces: list[Piece]) -> int:
    return line.columns[-1] + len(pieces[line.last - 1].text) - line.columns[at - line.first]
