# SPDX-License-Identifier: Apache-2.0
"""A model as readers of other formats give it: variables, and tables of numbers over them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.messages.source import Span

# (value, probability) of those values that can be, by rising value.
Row = tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class Variable:
    """What takes one of a finite number of values; without ``names`` they go by number."""

    name: str
    size: int
    names: tuple[str, ...] | None = None
    visible: bool = False

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Return the values by name."""
        return {name: number for number, name in enumerate(self.names or ())}

    def shown(self, value: int) -> str:
        """Return a value as the file calls it."""
        return self.names[value] if self.names is not None else str(value)


@dataclass(frozen=True)
class Read:
    """A variable that a table depends on.

    ``kind`` is ``action``, ``state`` (before the step), ``next`` (after it) or ``observation``; ``number``
    says which of these.
    """

    kind: str
    number: int = 0


@dataclass(frozen=True)
class Law:
    """The distribution of a variable: a row for all values of ``reads``."""

    reads: tuple[Read, ...]
    rows: Table[Row]


@dataclass(frozen=True)
class Gain:
    """A term of the reward: a number for all values of ``reads``."""

    name: str
    reads: tuple[Read, ...]
    values: Table[float]


@dataclass(frozen=True)
class ForeignModel:
    """A finite POMDP: laws of the start, of each step and of what is seen, one for each variable.

    ``notes`` are sentences about what the reader changed. ``discount_place`` is None where the file
    gives no discount, which counts as 1.
    """

    format: str
    discount: float
    actions: tuple[Variable, ...]
    states: tuple[Variable, ...]
    observations: tuple[Variable, ...]
    starts: tuple[Law, ...]
    transitions: tuple[Law, ...]
    sensors: tuple[Law, ...]
    rewards: tuple[Gain, ...]
    notes: tuple[str, ...] = ()
    discount_place: Span | None = None

    def variable(self, read: Read) -> Variable:
        """Return the variable that ``read`` names."""
        groups = {"action": self.actions, "observation": self.observations}
        return groups.get(read.kind, self.states)[read.number]

    def sizes(self, reads: Sequence[Read]) -> list[int]:
        """Return how many values each of ``reads`` takes."""
        return [self.variable(r).size for r in reads]


def count(sizes: Sequence[int]) -> int:
    """Return how many combinations of values there are."""
    return math.prod(sizes)


def combinations(sizes: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield all combinations of values, the last running fastest."""
    return product(*map(range, sizes))


def position(values: Sequence[int], sizes: Sequence[int]) -> int:
    """Return which of the combinations ``values`` is."""
    result = 0
    for value, size in zip(values, sizes, strict=True):
        result = result * size + value
    return result


def drawing_order(laws: Sequence[Law], kind: str) -> list[int]:
    """Return the laws' numbers, each behind those that it reads as ``kind``; without those on a cycle."""
    order: list[int] = []
    waiting = list(range(len(laws)))
    while True:
        ready = [n for n in waiting if all(r.kind != kind or r.number in order for r in laws[n].reads)]
        if not ready:
            return order
        order += ready
        waiting = [n for n in waiting if n not in ready]
