# SPDX-License-Identifier: Apache-2.0
"""Functions of several finite variables as decision diagrams: equal parts are one object.

A node has a part for each value of its variable; the parts of the last variable are entries. A table that
says the same of most combinations takes the room of what it says.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any, Generic, TypeVar

Entry = TypeVar("Entry", bound=Hashable)
Other = TypeVar("Other", bound=Hashable)
Node = Any  # a tuple of nodes, or an entry below the last variable


class Table(Generic[Entry]):
    """The entries for all values of variables of given sizes, the last running fastest."""

    def __init__(self, sizes: Sequence[int], root: Node) -> None:
        """Take a diagram whose equal parts are one object, as ``Parts`` makes them."""
        self.sizes, self.root = tuple(sizes), root

    @staticmethod
    def of(sizes: Sequence[int], entries: Sequence[Entry]) -> Table[Entry]:
        """Return the table of entries that are listed."""
        parts: Parts[Entry] = Parts()
        nodes: list[Node] = [parts.entry(e) for e in entries]
        for size in reversed(sizes):
            nodes = [parts.node(nodes[at : at + size]) for at in range(0, len(nodes), size)]
        return Table(sizes, nodes[0])

    def at(self, values: Sequence[int]) -> Entry:
        """Return the entry of a combination of values."""
        node = self.root
        for value in values:
            node = node[value]
        found: Entry = node
        return found

    def entries(self) -> list[Entry]:
        """Return the entries of all combinations, in order."""
        nodes = [self.root]
        for _ in self.sizes:
            nodes = [part for node in nodes for part in node]
        return nodes

    def levels(self) -> list[list[Node]]:
        """Return the distinct nodes of each variable, and last the distinct entries, as first met."""
        levels = [[self.root]]
        for _ in self.sizes:
            levels.append(_distinct(part for node in levels[-1] for part in node))
        return levels

    def distinct(self) -> list[Entry]:
        """Return the entries that differ, as they are first met."""
        return self.levels()[-1]

    def mapped(self, function: Callable[[Entry], Other]) -> Table[Other]:
        """Return the table of what ``function`` makes of the entries."""
        return Table(self.sizes, Parts[Other]().rebuilt(self.root, len(self.sizes), function))

    def found(self, wanted: Callable[[Entry], bool]) -> dict[Entry, tuple[tuple[int, ...], int]]:
        """Return the ``wanted`` entries: the first combination that has each, and how many have it."""
        known: dict[int, dict[Entry, tuple[tuple[int, ...], int]]] = {}

        def found(node: Node, below: int) -> dict[Entry, tuple[tuple[int, ...], int]]:
            if not below:
                return {node: ((), 1)} if wanted(node) else {}
            if id(node) not in known:
                here: dict[Entry, tuple[tuple[int, ...], int]] = {}
                for value, part in enumerate(node):
                    for entry, (values, number) in found(part, below - 1).items():
                        first, before = here.get(entry, ((value, *values), 0))
                        here[entry] = (first, before + number)
                known[id(node)] = here
            return known[id(node)]

        return found(self.root, len(self.sizes))

    def tested(self) -> list[bool]:
        """Return for each variable whether any entry depends on it."""
        return [any(len(set(map(id, node))) > 1 for node in nodes) for nodes in self.levels()[:-1]]

    def without(self, kept: Sequence[bool]) -> Table[Entry]:
        """Return the table of the variables that are ``kept``; no entry depends on the others."""

        def shorter(node: Node, depth: int) -> Node:
            while depth < len(kept) and not kept[depth]:
                node, depth = node[0], depth + 1
            if depth == len(kept):
                return node
            key = id(node)
            if key not in known:
                known[key] = parts.node([shorter(part, depth + 1) for part in node])
            return known[key]

        parts: Parts[Entry] = Parts()
        known: dict[int, Node] = {}
        sizes = [size for size, keep in zip(self.sizes, kept, strict=True) if keep]
        return Table(sizes, shorter(self.root, 0))


class Parts(Generic[Entry]):
    """Keeps one object of all parts that are equal."""

    def __init__(self) -> None:
        self._entries: dict[Entry, Entry] = {}
        self._nodes: dict[tuple[int, ...], Node] = {}  # by the parts that they have

    def entry(self, entry: Entry) -> Entry:
        """Return the entry that stands for all that equal this one."""
        return self._entries.setdefault(entry, entry)

    def node(self, parts: Sequence[Node]) -> Node:
        """Return the node that has these parts, which are unique themselves."""
        key = tuple(map(id, parts))
        found = self._nodes.get(key)
        if found is None:
            found = self._nodes[key] = tuple(parts)
        return found

    def rebuilt(self, root: Node, depth: int, function: Callable[[Any], Entry]) -> Node:
        """Return a diagram of ``depth`` variables with what ``function`` makes of its entries."""
        known: dict[tuple[int, int], Node] = {}

        def rebuild(node: Node, below: int) -> Node:
            key = (below, id(node))
            if key not in known:
                known[key] = (
                    self.node([rebuild(part, below - 1) for part in node])
                    if below
                    else self.entry(function(node))
                )
            return known[key]

        return rebuild(root, depth)


def _distinct(nodes: Iterator[Node]) -> list[Node]:
    return list({id(node): node for node in nodes}.values())
