# SPDX-License-Identifier: Apache-2.0
"""Files of policies on the exact belief, for ``--load-policy``: ``exact/policy.hpp`` states their form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass


@dataclass
class ClassVectors:
    """Vectors over states that look alike: (action, the values of all these states, in order)."""

    states: list[int]
    vectors: list[tuple[int, tuple[float, ...]]]


def policy_lines(policy_hash: int, classes: Sequence[ClassVectors]) -> Iterator[str]:
    """Yield the lines of a policy's file; of equal vectors the first is written."""
    yield "hypgen-policy-1\n"
    yield f"{policy_hash} {len(classes)}\n"
    for of_class in classes:
        actions: dict[tuple[float, ...], int] = {}
        for action, values in of_class.vectors:
            actions.setdefault(values, action)
        yield f"{len(actions)} 0\n"
        for values, action in actions.items():
            yield f"{action} 0 {' '.join(map(repr, values))}\n"
