# SPDX-License-Identifier: Apache-2.0
"""The product of all state variables: rows and gains of one action at a time."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.foreign.tables.foreign_model import (
    ForeignModel,
    Law,
    Read,
    combinations,
    drawing_order,
    position,
)
from hypgen.dsl.foreign.tables.reduction import reduced_gain, reduced_law

Row = list[tuple[int, float]]


class FlatModel:
    """States by number, with what each action leads to and earns."""

    def __init__(self, model: ForeignModel) -> None:
        self.model, self.sizes = model, [v.size for v in model.states]
        # Values of the actions, of the states and of the next states stand in one list.
        self.before = len(model.actions)
        self.after = self.before + len(model.states)
        steps, gains = map(reduced_law, model.transitions), map(reduced_gain, model.rewards)
        self.laws = self._in_order(list(steps), "next", self.after)
        self.gains = [(self._places(gain.reads), gain.values) for gain in gains]
        self.gains_see_next = any(place >= self.after for places, _ in self.gains for place in places)
        starts = self._in_order(model.starts, "state", self.before)
        self.start = self._joint(starts, [0] * self.before)
        self.states: list[tuple[int, ...]] = list(combinations(self.sizes))

    def step(self, action: tuple[int, ...], state: int) -> tuple[Row, float]:
        """Return a state's row and what is earned there, as expected."""
        known = [*action, *self.states[state]]
        row = self._joint(self.laws, known)
        if not self.gains_see_next:
            return row, self._gain(known)
        return row, sum(p * self._gain([*known, *self.states[n]]) for n, p in row)

    def reached(self, action: tuple[int, ...], most: int) -> dict[int, tuple[Row, float]] | None:
        """Return the steps of all states that the action leads to; None beyond ``most`` entries of rows."""
        steps: dict[int, tuple[Row, float]] = {}
        waiting = [state for state, _ in self.start]
        while waiting:
            state = waiting.pop()
            if state in steps:
                continue
            steps[state] = self.step(action, state)
            most -= len(steps[state][0])
            if most < 0:
                return None
            waiting += [n for n, _ in steps[state][0] if n not in steps]
        return steps

    def _places(self, reads: Sequence[Read]) -> list[int]:
        first = {"action": 0, "state": self.before, "next": self.after}
        return [first[read.kind] + read.number for read in reads]

    def _in_order(self, laws: Sequence[Law], kind: str, first: int) -> list[tuple[int, list[int], Law]]:
        """Return laws in the order of drawing, with the places of what they draw and of what they read."""
        return [(first + n, self._places(laws[n].reads), laws[n]) for n in drawing_order(laws, kind)]

    def _joint(self, laws: Sequence[tuple[int, list[int], Law]], known: list[int]) -> Row:
        """Return the joint law of all state variables, whose values come behind those in ``known``."""
        first = len(known)
        partial: list[tuple[list[int], float]] = [([*known, *self.sizes], 1.0)]
        for place, reads, law in laws:
            extended = []
            for given, probability in partial:
                *others, (last, share) = law.rows.at([given[read] for read in reads])
                for value, p in others:
                    extended.append(([*given[:place], value, *given[place + 1 :]], probability * p))
                given[place] = last
                extended.append((given, probability * share))
            partial = extended
        total = sum(p for _, p in partial)  # off 1 as the file rounds, which would count as an end
        return [(position(given[first:], self.sizes), p / total) for given, p in partial]

    def _gain(self, known: list[int]) -> float:
        return sum(values.at([known[read] for read in reads]) for reads, values in self.gains)
