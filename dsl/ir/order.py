# SPDX-License-Identifier: Apache-2.0
"""The order of declarations that need each other: the same for the same text."""

from __future__ import annotations

from collections.abc import Mapping, Reversible


def dependencies_first(needed: Mapping[str, Reversible[str]]) -> list[str]:
    """Return the names such that each comes after those that it needs, otherwise in the order given.

    ``needed`` has no cycle. ``graphlib`` would put all that needs nothing first, and the order decides in
    which order tables and inits are printed.
    """
    order: dict[str, None] = {}
    stack = [(name, False) for name in reversed(list(needed))]
    while stack:
        name, expanded = stack.pop()
        if name in order:
            continue
        if expanded:
            order[name] = None
        else:
            stack.append((name, True))
            stack += [(other, False) for other in reversed(needed[name])]
    return list(order)
