# SPDX-License-Identifier: Apache-2.0
"""Small tables as text that a person would write: rows as draws, tables as matches."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from hypgen.dsl.foreign.tables.foreign_model import Row
from hypgen.dsl.foreign.tables.numbers import in_full
from hypgen.dsl.foreign.tables.plan import groups_of
from hypgen.dsl.foreign.tables.rows import in_order
from hypgen.dsl.foreign.tables.table import Table

Entry = TypeVar("Entry", bound=Hashable)
WIDTH = 100
MOST_ENTRIES = 6  # of a row that is written out
MOST_LINES = 40
_LONGEST_CHOICE = 70
EQUAL = 2e-6


@dataclass(frozen=True)
class Values:
    """How the values of a finite type are written."""

    type_name: str
    names: Sequence[str]


def row_text(row: Row, values: Values) -> str | None:
    """Return a row as a draw or a value; None if that would be long."""
    size = len(values.names)
    if len(row) == 1:
        return values.names[row[0][0]]
    if len(row) > 2 and all(abs(p * len(row) - 1) <= EQUAL * len(row) for _, p in row):
        if len(row) == size:
            return f"uniform({values.type_name})"
        if len(row) == size - 1:
            [left_out] = set(range(size)) - {v for v, _ in row}
            return f"uniform(v in {values.type_name} where v != {values.names[left_out]})"
    if len(row) == size == 2 and abs(row[0][1] - 0.5) <= EQUAL:
        return f"uniform({values.type_name})"
    if len(row) > MOST_ENTRIES:
        return None
    row = in_order(row)
    entries = [f"{values.names[v]}: {in_full(p)}" for v, p in row[:-1]]
    return "{ " + ", ".join(entries) + f", else {values.names[row[-1][0]]} }}"


@dataclass(frozen=True)
class Scrutinee:
    """What a table reads: its text, and how its values are written."""

    text: str
    values: Values


def match_text(
    reads: Sequence[Scrutinee],
    table: Table[Entry],
    leaf: Callable[[Entry], str | None],
    own: Callable[[Scrutinee, Sequence[Entry]], bool],
    indent: int,
) -> list[str] | None:
    """Return a table as lines of nested matches; None if a leaf has no text or lines get long or many.

    ``own`` says whether entries are just the value that is read.
    """
    lines = _lines(reads, table.root, leaf, own, indent)
    if lines is None or len(lines) > MOST_LINES or max(map(len, lines)) > WIDTH - indent - 24:
        return None
    return lines


def _lines(
    reads: Sequence[Scrutinee],
    node: Any,
    leaf: Callable[[Entry], str | None],
    own: Callable[[Scrutinee, Sequence[Entry]], bool],
    indent: int,
) -> list[str] | None:
    if not reads:
        text = leaf(node)
        return None if text is None else [text]
    read, rest = reads[0], reads[1:]
    if not rest and own(read, node):
        return [read.text]
    names = read.values.names
    if len(names) > 4 * MOST_LINES:
        return None
    groups = groups_of(node)
    if len(groups) > MOST_LINES:
        return None
    if len(groups) == 1:
        return _lines(rest, node[0], leaf, own, indent)
    arms: list[tuple[str, list[str]]] = []
    for members, is_else in else_last(groups):
        inner = _lines(rest, node[members[0]], leaf, own, indent + 2)
        if inner is None or len(inner) > MOST_LINES:
            return None
        arms.append(("else" if is_else else " | ".join(names[m] for m in members), inner))
    return match_lines(read, arms, indent)


def else_last(groups: Sequence[list[int]]) -> list[tuple[list[int], bool]]:
    """Return groups of values in the order of a match's arms, and which of them is its ``else``."""
    last = max(groups, key=lambda g: (len(g), g[0]))
    return [(g, False) for g in groups if g is not last] + [(last, len(last) > 1)]


def match_lines(read: Scrutinee, arms: Sequence[tuple[str, list[str]]], indent: int) -> list[str]:
    """Return the lines of a match with these patterns and what follows them."""
    single = all(len(inner) == 1 for _, inner in arms)
    if single and len(arms) == 2 and arms[1][0] == "else" and "|" not in arms[0][0]:
        value, then, otherwise = arms[0][0], arms[0][1][0], arms[1][1][0]
        choice = f"if {read.text} == {value} then {then} else {otherwise}"
        if len(choice) <= _LONGEST_CHOICE and not then.startswith("if ") and not otherwise.startswith("if "):
            return [choice]
    longest = max(len(pattern) for pattern, _ in arms) if single else 0
    lines = [f"match {read.text} {{"]
    for pattern, inner in arms:
        lines.append(" " * (indent + 2) + f"{pattern:{longest}} => {inner[0]}")
        lines += inner[1:]
    return [*lines, " " * indent + "}"]
