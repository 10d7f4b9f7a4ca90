# SPDX-License-Identifier: Apache-2.0
"""Large tables as consts: rows shared, values listed in strings, successors and not states.

A row is drawn by its successors one after the other. Rows of like length share one expression, the shorter
ones filled up with their last value; a row with a good part of all values in it is one of weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from hypgen.dsl.foreign.tables.foreign_model import Row
from hypgen.dsl.foreign.tables.names import Names, type_name
from hypgen.dsl.foreign.tables.numbers import in_full, shown
from hypgen.dsl.foreign.tables.rows import in_order
from hypgen.dsl.foreign.writer.cases import EQUAL, WIDTH

_LENGTHS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
_MOST_READ = 20_000  # entries of a table with lines of the usual width
_LONG = 4_000  # columns of others
_SHORT = 8  # never weights for all values
Entry = TypeVar("Entry", contravariant=True)


@dataclass(frozen=True)
class Index:
    """What a table reads: the expression, and its type's name."""

    text: str
    type_name: str


def array(name: str, type_: str, indices: str, words: Sequence[str]) -> list[str]:
    """Return a const array whose entries are listed in strings."""
    head = f"const {name}: {type_}[{indices}] ="
    # Nobody reads the long ones, and a string takes longer to parse than its words.
    width = WIDTH - 6 if len(words) <= _MOST_READ else _LONG
    lines, line = [], ""
    for word in words:
        if line and len(line) + len(word) > width:
            lines.append(line)
            line = ""
        line = f"{line} {word}" if line else word
    lines.append(line)
    if len(lines) == 1 and len(head) + len(lines[0]) + 3 <= WIDTH:
        return [f'{head} "{lines[0]}"']
    return [f"{head} [", *(f'  "{text}",' for text in lines[:-1]), f'  "{lines[-1]}"', "]"]


def weights(stem: str, target: Index, row: Row, size: int, names: Names) -> tuple[list[str], str]:
    """Return the table of a row that nothing is read for, and the draw by weights of all values."""
    table = names.unique(f"{stem}_weight", "weight")
    lines = array(table, "float", target.type_name, _dense(row, size))
    return lines, f"weighted(v in {target.type_name}: {table}[v])"


def _dense(row: Row, size: int) -> list[str]:
    words = ["0"] * size
    for value, probability in row:
        words[value] = in_full(probability)
    return words


class Parts(Protocol[Entry]):
    """Declares the parts of a large table, and says how each is read."""

    def part(self, name: str, reads: Sequence[Index], entries: Sequence[Entry]) -> str:
        """Return the text of a part, whose table may go by ``name``."""

    def declarations(self) -> list[str]:
        """Return the lines of all tables."""


def _read(table: str, reads: Sequence[Index]) -> str:
    return f"{table}[{', '.join(r.text for r in reads)}]"


def _by(reads: Sequence[Index]) -> str:
    return ", ".join(r.type_name for r in reads)


class Numbers:
    """Tables of numbers."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self.lines: list[str] = []

    def part(self, name: str, reads: Sequence[Index], entries: Sequence[float]) -> str:
        """Return the text of a part."""
        table = self.names.unique(f"{name}_table", "table")
        self.lines += array(table, "float", _by(reads), list(map(shown, entries)))
        return _read(table, reads)

    def declarations(self) -> list[str]:
        """Return the lines of all tables."""
        return self.lines


class Successors:
    """Tables of a law that draws nothing."""

    def __init__(self, target: Index, values: Sequence[str], names: Names) -> None:
        self.target, self.values, self.names = target, values, names
        self.lines: list[str] = []

    def part(self, name: str, reads: Sequence[Index], entries: Sequence[Row]) -> str:
        """Return the text of a part."""
        table = self.names.unique(f"{name}_after", "table")
        self.lines += array(
            table, self.target.type_name, _by(reads), [self.values[row[0][0]] for row in entries]
        )
        return _read(table, reads)

    def declarations(self) -> list[str]:
        """Return the lines of all tables."""
        return self.lines


class Draws:
    """The distinct rows of a law, those of weights first, and tables that say which row is where."""

    def __init__(
        self, stem: str, target: Index, values: Sequence[str], distinct: Sequence[Row], names: Names
    ) -> None:
        self.stem, self.target, self.values, self.names = stem, target, values, names
        self.wide = [r for r in distinct if self._is_wide(r)]
        self.wide.sort(key=lambda r: not self._is_even(r))
        self.listed = [r for r in distinct if not self._is_wide(r)]
        self.type_stem = type_name(stem)
        self.row_type = names.unique(f"{self.type_stem}Row", "Row")
        self.function = names.unique(f"{stem}_by", "draw")
        self.numbers = {row: str(number) for number, row in enumerate(self.wide + self.listed)}
        self.lines: list[str] = []

    def _is_wide(self, row: Row) -> bool:
        return len(row) > _SHORT and (len(row) > _LENGTHS[-1] or 4 * len(row) > len(self.values))

    def _is_even(self, row: Row) -> bool:
        size = len(self.values)
        return len(row) == size and all(abs(p * size - 1) <= EQUAL * size for _, p in row)

    def part(self, name: str, reads: Sequence[Index], entries: Sequence[Row]) -> str:
        """Return the text of a part."""
        if not reads:
            return f"{self.function}({self.numbers[entries[0]]})"
        table = self.names.unique(f"{name}_row", "row")
        self.lines += array(table, self.row_type, _by(reads), [self.numbers[row] for row in entries])
        return f"{self.function}({_read(table, reads)})"

    def declarations(self) -> list[str]:
        """Return the lines of all tables, and of the function that draws from a row."""
        lines = [f"type {self.row_type} = 0 .. {len(self.numbers) - 1}", *self.lines]
        more, branches = self._weighted()
        lines += more
        if self.listed:
            more, last = self._listed(self.row_type)
            lines += more
        else:
            last = [branches.pop()[1]]
        lead = "  "
        body = []
        for condition, draw in branches:
            body.append(f"{lead}if {condition} then {draw}")
            lead = "  else "
        body += [lead + last[0], *last[1:]]
        return [*lines, f"fn {self.function}(r: {self.row_type}): {self.target.type_name} ~", *body]

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
                chances.append(in_full(probability) if number < len(row) else "0")
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
