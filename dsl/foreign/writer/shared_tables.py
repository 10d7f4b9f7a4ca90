# SPDX-License-Identifier: Apache-2.0
"""Large tables as consts: rows shared, values listed in strings, successors and not states.

A row is drawn by its successors one after the other. Rows of like length share one expression, the shorter
ones filled up with their last value; a row with a good part of all values in it is one of weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hypgen.dsl.foreign.tables.foreign_model import Row
from hypgen.dsl.foreign.tables.names import Names, type_name
from hypgen.dsl.foreign.tables.numbers import shown
from hypgen.dsl.foreign.tables.rows import in_order
from hypgen.dsl.foreign.writer.cases import EQUAL, WIDTH

_LENGTHS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
_SHORT = 8  # never weights for all values


@dataclass(frozen=True)
class Index:
    """What a table reads: the expression, and its type's name."""

    text: str
    type_name: str


@dataclass(frozen=True)
class Written:
    """Declarations, and the expression that uses them."""

    declarations: list[str]
    text: str
    is_draw: bool


def array(name: str, type_: str, indices: str, words: Sequence[str]) -> list[str]:
    """Return a const array whose entries are listed in strings."""
    head = f"const {name}: {type_}[{indices}] ="
    lines, line = [], ""
    for word in words:
        if line and len(line) + len(word) > WIDTH - 6:
            lines.append(line)
            line = ""
        line = f"{line} {word}" if line else word
    lines.append(line)
    if len(lines) == 1 and len(head) + len(lines[0]) + 3 <= WIDTH:
        return [f'{head} "{lines[0]}"']
    return [f"{head} [", *(f'  "{text}",' for text in lines[:-1]), f'  "{lines[-1]}"', "]"]


def law(
    stem: str, target: Index, values: Sequence[str], reads: Sequence[Index], rows: Sequence[Row], names: Names
) -> Written:
    """Return the tables of a law, and the draw (or value) of type ``target`` from them."""
    at = ", ".join(r.text for r in reads)
    by = ", ".join(r.type_name for r in reads)
    if all(len(row) == 1 for row in rows):
        table = names.unique(f"{stem}_after", "table")
        lines = array(table, target.type_name, by, [values[row[0][0]] for row in rows])
        return Written(lines, f"{table}[{at}]", False)
    if not reads:
        return _weights(stem, target, rows[0], len(values), names)
    return _Rows(stem, target, values, rows, names).written(at, by)


def _weights(stem: str, target: Index, row: Row, size: int, names: Names) -> Written:
    """Return a draw by weights of all values."""
    table = names.unique(f"{stem}_weight", "weight")
    lines = array(table, "float", target.type_name, _dense(row, size))
    return Written(lines, f"weighted(v in {target.type_name}: {table}[v])", True)


def _dense(row: Row, size: int) -> list[str]:
    words = ["0"] * size
    for value, probability in row:
        words[value] = shown(probability)
    return words


class _Rows:
    """The distinct rows of a law, those of weights first."""

    def __init__(
        self, stem: str, target: Index, values: Sequence[str], rows: Sequence[Row], names: Names
    ) -> None:
        self.stem, self.target, self.values, self.rows, self.names = stem, target, values, rows, names
        distinct = list(dict.fromkeys(rows))
        self.wide = [r for r in distinct if self._is_wide(r)]
        self.wide.sort(key=lambda r: not self._is_even(r))
        self.listed = [r for r in distinct if not self._is_wide(r)]
        self.type_stem = type_name(stem)

    def _is_wide(self, row: Row) -> bool:
        return len(row) > _SHORT and (len(row) > _LENGTHS[-1] or 4 * len(row) > len(self.values))

    def _is_even(self, row: Row) -> bool:
        size = len(self.values)
        return len(row) == size and all(abs(p * size - 1) <= EQUAL * size for _, p in row)

    def written(self, at: str, by: str) -> Written:
        """Return the tables and the draw."""
        distinct = self.wide + self.listed
        row_type = self.names.unique(f"{self.type_stem}Row", "Row")
        row_of = self.names.unique(f"{self.stem}_row", "row")
        numbers = {row: str(number) for number, row in enumerate(distinct)}
        lines = [f"type {row_type} = 0 .. {len(distinct) - 1}"]
        lines += array(row_of, row_type, by, [numbers[row] for row in self.rows])
        more, branches = self._weighted()
        lines += more
        if self.listed:
            more, last = self._listed(row_type)
            lines += more
        else:
            last = [branches.pop()[1]]
        lead = "  "
        body = []
        for condition, draw in branches:
            body.append(f"{lead}if {condition} then {draw}")
            lead = "  else "
        body += [lead + last[0], *last[1:]]
        function = self.names.unique(f"{self.stem}_by", "draw")
        lines += [f"fn {function}(r: {row_type}): {self.target.type_name} ~", *body]
        return Written(lines, f"{function}({row_of}[{at}])", True)

    def _weighted(self) -> tuple[list[str], list[tuple[str, str]]]:
        """Return the table of rows of weights, and draws from row r, each with its condition."""
        target, count = self.target.type_name, len(self.wide)
        evens = sum(map(self._is_even, self.wide[:1]))
        branches = [("r == 0", f"uniform({target})")] * evens
        if count == evens:
            return [], branches
        table = self.names.unique(f"{self.stem}_weight", "weight")
        words = [word for row in self.wide for word in _dense(row, len(self.values))]
        branches.append((f"r < {count}", f"weighted(v in {target}: {table}[r, v])"))
        return array(table, "float", f"0 .. {count - 1}, {target}", words), branches

    def _listed(self, row_type: str) -> tuple[list[str], list[str]]:
        """Return the tables of rows given by successors, and the lines of a draw from row r."""
        lengths = [next(n for n in _LENGTHS if len(row) <= n) for row in self.listed]
        if max(lengths) == 1:
            table = self.names.unique(f"{self.stem}_value", "value")
            words = [self.values[0]] * len(self.wide) + [self.values[row[0][0]] for row in self.listed]
            return array(table, self.target.type_name, row_type, words), [f"{table}[r]"]
        most = max(lengths)
        firsts = ["0"] * len(self.wide)
        values: list[str] = []
        chances: list[str] = []
        for row, length in zip(self.listed, lengths, strict=True):
            firsts.append(str(len(values)))
            ordered = in_order(row)
            for number in range(length):
                following, probability = ordered[min(number, len(row) - 1)]
                values.append(self.values[following])
                chances.append(shown(probability) if number < len(row) else "0")
        padding = most - lengths[-1]  # so that an entry and those behind it are within the table
        values += [self.values[0]] * padding
        chances += ["0"] * padding
        names = self.names
        first, size, value, chance = (
            names.unique(f"{self.stem}_{what}", what) for what in ("first", "size", "value", "chance")
        )
        entry = names.unique(f"{self.type_stem}Entry", "Entry")
        lines = [f"type {entry} = 0 .. {len(values) - 1}"]
        lines += array(first, f"0 .. {len(values) - most}", row_type, firsts)
        if len(set(lengths)) > 1:
            sizes = ["1"] * len(self.wide) + [str(n) for n in lengths]
            lines += array(size, f"1 .. {most}", row_type, sizes)
        lines += array(value, self.target.type_name, entry, values)
        lines += array(chance, "prob", entry, chances)
        head = f"let k = {first}[r] in "
        if len(set(lengths)) == 1:
            return lines, _draw(head, most, value, chance, "")
        body = [head + f"match {size}[r] {{"]
        for length in sorted(set(lengths)):
            pattern = "else" if length == most else str(length)
            body += _draw(f"    {pattern} => ", length, value, chance, "  ")
        return lines, [*body, "  }"]


def _draw(head: str, length: int, value: str, chance: str, indent: str) -> list[str]:
    """Return the lines of a draw among ``length`` entries from k on."""

    def at(table: str, offset: int) -> str:
        return f"{table}[k + {offset}]" if offset else f"{table}[k]"

    if length == 1:
        return [head + at(value, 0)]
    entries = [f"{at(value, n)}: {at(chance, n)}" for n in range(length - 1)] + [
        f"else {at(value, length - 1)}"
    ]
    whole = head + "{ " + ", ".join(entries) + " }"
    if len(whole) <= WIDTH:
        return [whole]
    lines = [head + "{"]
    line = ""
    for number, text in enumerate(entries):
        text += "," if number < length - 1 else ""
        if line and len(line) + len(text) > WIDTH - 12:
            lines.append(f"{indent}    {line}")
            line = ""
        line = f"{line} {text}" if line else text
    return [*lines, f"{indent}    {line}", f"{indent}  }}"]
