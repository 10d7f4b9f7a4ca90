# SPDX-License-Identifier: Apache-2.0
"""Search trees that are cut to their most visited nodes."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any

Node = dict[str, Any]
_CHILDREN = ("actions", "groups")  # of a belief, and of an action


def size(tree: Mapping[str, Any]) -> int:
    """Return how many nodes a tree has, beliefs and actions."""
    return 1 + sum(size(child) for _, child in _children(tree))


def cut(tree: Mapping[str, Any], most: int) -> Node:
    """Return the part of a tree that most trials took, ``most`` nodes or fewer.

    The root's actions come first: they are what the decision was between.
    Where children are gone, ``actions_left_out`` and ``groups_left_out`` count them. A child stays only where
    its parent does.
    """
    root: Node = _bare(tree)
    order = itertools.count()  # equals stay in order
    waiting = [(-math.inf, next(order), kind, root, child) for kind, child in _children(tree)]
    left = most - 1
    while waiting and left > 0:
        _, _, kind, parent, child = heapq.heappop(waiting)
        kept = _bare(child)
        parent.setdefault(kind, []).append(kept)
        left -= 1
        for below_kind, below in _children(child):
            heapq.heappush(waiting, (-_visits(below), next(order), below_kind, kept, below))
    for _, _, kind, parent, _ in waiting:
        parent.setdefault(kind, [])
        parent[f"{kind}_left_out"] = parent.get(f"{kind}_left_out", 0) + 1
    return root


def _children(node: Mapping[str, Any]) -> Iterator[tuple[str, Node]]:
    return ((kind, child) for kind in _CHILDREN for child in node.get(kind, ()))


def _bare(node: Mapping[str, Any]) -> Node:
    return {key: value for key, value in node.items() if key not in _CHILDREN}


def _visits(node: Mapping[str, Any]) -> int:
    return int(node.get("visits", 0))
