# SPDX-License-Identifier: Apache-2.0
"""Large tables as matches whose arms are tables of fewer reads, where that takes far less room."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from itertools import compress
from typing import Any, Generic, TypeVar

from hypgen.dsl.foreign.tables.plan import Plan, groups_of
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.foreign.writer import cases
from hypgen.dsl.foreign.writer.cases import Scrutinee
from hypgen.dsl.foreign.writer.shared_tables import Index, Parts

Entry = TypeVar("Entry", bound=Hashable)
Small = Callable[[Sequence[Scrutinee], Table[Entry], int], "list[str] | None"]


class Branches(Generic[Entry]):
    """Writes a table. ``small`` gives the lines of a part that needs no table, None of any other."""

    def __init__(
        self, reads: Sequence[Scrutinee], table: Table[Entry], small: Small[Entry], parts: Parts[Entry]
    ) -> None:
        self.reads, self.table, self.small, self.parts = reads, table, small, parts
        self.plan = Plan(table)
        self.written: dict[int, str] = {}  # texts of parts that are tables

    def lines(self, name: str, indent: int) -> list[str]:
        """Return the lines of the whole, ``name`` being what tables may go by."""
        return self._lines(self.table.root, 0, name, indent)

    def _lines(self, node: Any, depth: int, name: str, indent: int) -> list[str]:
        if depth == len(self.reads) or not self.plan.branches(node):
            return self._part(node, depth, name, indent)
        groups = groups_of(node)
        if len(groups) == 1:
            return self._lines(node[0], depth + 1, name, indent)
        read = self.reads[depth]
        arms: list[tuple[str, list[str]]] = []
        for members, is_else in cases.else_last(groups):
            inner_name = name if is_else else f"{name}_{read.values.names[members[0]]}"
            inner = self._lines(node[members[0]], depth + 1, inner_name, indent + 2)
            patterns = ["else"] if is_else else _patterns([read.values.names[m] for m in members])
            arms += [(pattern, inner) for pattern in patterns]
        return cases.match_lines(read, arms, indent)

    def _part(self, node: Any, depth: int, name: str, indent: int) -> list[str]:
        whole: Table[Entry] = Table(self.table.sizes[depth:], node)
        kept = whole.tested()
        reads, part = list(compress(self.reads[depth:], kept)), whole.without(kept)
        lines = self.small(reads, part, indent)
        if lines is not None:
            return lines
        if id(node) not in self.written:
            indices = [Index(r.text, r.values.type_name) for r in reads]
            self.written[id(node)] = self.parts.part(name, indices, part.entries())
        return [self.written[id(node)]]


def _patterns(names: Sequence[str]) -> list[str]:
    """Return the patterns of names that lead to the same: several where one would be long."""
    patterns = [names[0]]
    for name in names[1:]:
        if len(patterns[-1]) + len(name) > cases.WIDTH // 2:
            patterns.append(name)
        else:
            patterns[-1] += f" | {name}"
    return patterns
