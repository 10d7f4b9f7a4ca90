# SPDX-License-Identifier: Apache-2.0
"""A table in the making, as a decision diagram: each write changes the numbers of a box of combinations."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from hypgen.dsl.foreign.tables.table import Parts, Table

Entry = TypeVar("Entry", bound=Hashable)


class TooLargeError(Exception):
    """The writes or the diagram are beyond their limits."""


@dataclass(slots=True)
class _Node:
    """What follows each value of a variable: ``parts``, and ``rest`` for values that are not among them.

    An ``owned`` node stands in one place only, so that it may be changed there; so do its ancestors then.
    """

    rest: Any  # a node, a number, or None where nothing has been written
    parts: dict[int, Any] = field(default_factory=dict)
    owned: bool = False

    def own(self) -> _Node:
        """Return this node if it may be changed, or a copy that may be."""
        if self.owned:
            return self
        _disown(self.rest)
        for part in self.parts.values():
            _disown(part)
        return _Node(self.rest, dict(self.parts), True)


def _disown(part: Any) -> None:
    if isinstance(part, _Node):
        part.owned = False


class Diagram:
    """Numbers for all values of variables of given ``sizes``; ``most`` parts may be written."""

    def __init__(self, sizes: Sequence[int], most: int) -> None:
        self.sizes, self.left = tuple(sizes), most
        root: Any = None
        for _ in sizes:
            root = _Node(root)
        self.root = root

    def write(
        self,
        box: Sequence[int | None],
        strides: Sequence[int],
        number: Callable[[int], float],
        diagonal: bool = False,
    ) -> None:
        """Write the numbers of the combinations in ``box``, where None stands for all values of a variable.

        ``number`` gives them by the sum of values times ``strides``. With ``diagonal`` this sum is a value of
        the last variable, the only one that gets a number: the others have none from then on.
        """
        self.root = _Write(self, box, strides, number, diagonal).put(self.root, 0, 0)

    def table(self, entry: Callable[[Any], Entry], depth: int, most: int) -> Table[Entry]:
        """Return the table of the first ``depth`` variables with what ``entry`` makes of the parts below.

        Raises ``TooLargeError`` if its nodes would have more than ``most`` parts.
        """
        parts: Parts[Entry] = Parts()
        known: dict[int, Any] = {}
        left = most

        def built(node: Any, at: int) -> Any:
            nonlocal left
            if at == depth:
                return parts.entry(entry(node))
            if id(node) not in known:
                size = self.sizes[at]
                left -= size
                if left < 0:
                    raise TooLargeError
                children = [None if len(node.parts) == size else built(node.rest, at + 1)] * size
                for value, part in node.parts.items():
                    children[value] = built(part, at + 1)
                known[id(node)] = parts.node(children)
            return known[id(node)]

        return Table(self.sizes[:depth], built(self.root, 0))


class _Write:
    """One write: the parts that it meets in several places it changes once."""

    def __init__(
        self,
        diagram: Diagram,
        box: Sequence[int | None],
        strides: Sequence[int],
        number: Callable[[int], float],
        diagonal: bool,
    ) -> None:
        self.diagram, self.box, self.strides = diagram, box, strides
        self.number, self.diagonal = number, diagonal
        last = len(box)
        self.all_from = last  # from here on every combination gets the same number
        while (
            not diagonal
            and self.all_from
            and box[self.all_from - 1] is None
            and not strides[self.all_from - 1]
        ):
            self.all_from -= 1
        # The old part is kept beside the new one, as its number must not be given to another meanwhile.
        self.known: dict[tuple[int, int], tuple[_Node, _Node]] = {}
        self.whole: dict[tuple[int, int], Any] = {}

    def put(self, node: Any, depth: int, key: int) -> Any:
        """Return what ``node`` becomes."""
        self.diagram.left -= 1
        if self.diagram.left < 0:
            raise TooLargeError
        if depth == len(self.box):
            return self.number(key)
        if depth >= self.all_from:
            return self._same(depth, key)
        known = self.known.get((id(node), key))
        if known is not None:
            known[1].owned = False
            return known[1]
        if self.diagonal and depth == len(self.box) - 1:
            new = _Node(None, {key: self.number(key)}, True)
        else:
            new = node.own()
            self._change(new, depth, key)
        self.known[id(node), key] = node, new
        return new

    def _change(self, new: _Node, depth: int, key: int) -> None:
        value, stride = self.box[depth], self.strides[depth]
        if value is not None:
            old = new.parts.get(value, new.rest)
            new.parts[value] = self.put(old, depth + 1, key + stride * value)
        elif stride:
            new.parts = {
                v: self.put(new.parts.get(v, new.rest), depth + 1, key + stride * v)
                for v in range(self.diagram.sizes[depth])
            }
        else:
            new.rest = self.put(new.rest, depth + 1, key)
            _disown(new.rest)  # it stands for several values
            for value, part in new.parts.items():
                new.parts[value] = self.put(part, depth + 1, key)

    def _same(self, depth: int, key: int) -> Any:
        if (depth, key) not in self.whole:
            below = depth + 1 < len(self.box)
            self.whole[depth, key] = _Node(self._same(depth + 1, key) if below else self.number(key))
        return self.whole[depth, key]
