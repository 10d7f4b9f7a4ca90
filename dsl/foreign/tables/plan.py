# SPDX-License-Identifier: Apache-2.0
"""Which large tables are written as branches: those whose parts, each of few reads, take far less room."""

from __future__ import annotations

import math
from typing import Any

from hypgen.dsl.foreign.tables.table import Table

_SMALL = 1_000  # entries that are listed anyway
_MOST_NAMED = 64  # values that the patterns of a match may name


class Plan:
    """For each node of a table's diagram: the entries to write, and whether by branches of its variable."""

    def __init__(self, table: Table[Any]) -> None:
        self._sizes = table.sizes
        self._known: dict[int, tuple[frozenset[int], int, bool]] = {}
        self.entries = self._of(table.root, 0)[1]

    def branches(self, node: Any) -> bool:
        """Return whether a node is written as branches; those of one part are passed by."""
        return self._known[id(node)][2]

    def _of(self, node: Any, depth: int) -> tuple[frozenset[int], int, bool]:
        if depth == len(self._sizes):
            return frozenset(), 1, False
        known = self._known.get(id(node))
        if known is None:
            groups = groups_of(node)
            parts = [self._of(node[members[0]], depth + 1) for members in groups]
            tested = frozenset().union(*(part[0] for part in parts))
            listed, split, is_open = parts[0][1], 0, parts[0][2]
            if len(groups) > 1:
                tested |= {depth}
                listed = math.prod(self._sizes[d] for d in tested)
                split = sum(entries for _, entries, _ in parts) + len(groups)
                named = len(node) - max(map(len, groups))
                is_open = listed > _SMALL and 2 * split <= listed and named <= _MOST_NAMED
                if is_open:
                    listed = split
            known = self._known[id(node)] = (tested, listed, is_open)
        return known


def groups_of(node: Any) -> list[list[int]]:
    """Return the values that lead to the same part, together."""
    groups: dict[int, list[int]] = {}
    for value, part in enumerate(node):
        groups.setdefault(id(part), []).append(value)
    return list(groups.values())
