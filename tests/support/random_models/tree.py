# SPDX-License-Identifier: Apache-2.0
"""Text that can be made shorter and stays a model: trees of what may stand in whose place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

BATCH = 20


@dataclass(frozen=True)
class Node:
    """A piece of a model's text.

    ``sort`` says what may stand here: a type's name, ``draw of T``, or ``item`` for what may be missing.
    ``plain`` is the simplest text of that sort; it reads nothing.
    """

    sort: str
    plain: str
    parts: tuple[str | Node, ...]

    def __str__(self) -> str:
        return "".join(map(str, self.parts))


def shorter(root: Node) -> Iterator[Node]:
    """Yield ``root`` with one node made simpler, large nodes first: plain, or a part of its own."""
    for path in sorted(_paths(root), key=lambda p: -len(str(_at(root, p)))):
        node = _at(root, path)
        if str(node) != node.plain:
            yield _put(root, path, Node(node.sort, node.plain, (node.plain,)))
        for inner in _nearest(node):
            yield _put(root, path, inner)


def _paths(node: Node, path: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    for i, part in enumerate(node.parts):
        if isinstance(part, Node):
            yield (*path, i)
            yield from _paths(part, (*path, i))


def _at(node: Node, path: tuple[int, ...]) -> Node:
    for i in path:
        part = node.parts[i]
        assert isinstance(part, Node)
        node = part
    return node


def _put(node: Node, path: tuple[int, ...], new: Node) -> Node:
    if not path:
        return new
    part = node.parts[path[0]]
    assert isinstance(part, Node)
    changed = _put(part, path[1:], new)
    return replace(node, parts=(*node.parts[: path[0]], changed, *node.parts[path[0] + 1 :]))


def _nearest(node: Node) -> Iterator[Node]:
    """Yield the nodes of the same sort inside ``node`` that no other such node contains."""
    for part in node.parts:
        if isinstance(part, Node):
            if part.sort == node.sort:
                yield part
            else:
                for inner in _nearest(part):
                    if inner.sort == node.sort:
                        yield inner


def shrink(root: Node, failing: Callable[[Sequence[Node]], Node | None], rounds: int = 200) -> Node:
    """Return a small tree that still fails; ``failing`` gives the first of some trees that does."""
    for _ in range(rounds):
        candidates = iter(shorter(root))
        found = None
        while found is None and (batch := list(islice(candidates, BATCH))):
            found = failing(batch)
        if found is None:
            break
        root = found
    return root
