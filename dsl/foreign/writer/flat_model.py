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

Row = list[tuple[int, float]]


class FlatModel:
    """States by number, with what each action leads to and earns."""

    def __init__(self, model: ForeignModel) -> None:
        self.model, self.sizes = model, [v.size for v in model.states]
        self.start = self._joint(model.starts, "state", {})
        self.states: list[dict[int, int]] = [dict(enumerate(state)) for state in combinations(self.sizes)]

    def step(self, action: tuple[int, ...], state: int) -> tuple[Row, float]:
        """Return a state's row and what is earned there, as expected."""
        known = {"action": dict(enumerate(action)), "state": self.states[state]}
        row = self._joint(self.model.transitions, "next", known)
        return row, sum(p * self._gain({**known, "next": self.states[n]}) for n, p in row)

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

    def _joint(self, laws: Sequence[Law], kind: str, known: dict[str, dict[int, int]]) -> Row:
        """Return a joint law of all variables; reads of ``kind`` are of those drawn before."""
        partial: list[tuple[dict[int, int], float]] = [({}, 1.0)]
        for number in drawing_order(laws, kind):
            extended = []
            for given, probability in partial:
                row = laws[number].rows[self._position(laws[number].reads, {**known, kind: given})]
                extended += [({**given, number: v}, probability * p) for v, p in row]
            partial = extended
        numbers = range(len(self.sizes))
        total = sum(p for _, p in partial)  # off 1 as the file rounds, which would count as an end
        return [(position([given[n] for n in numbers], self.sizes), p / total) for given, p in partial]

    def _position(self, reads: Sequence[Read], known: dict[str, dict[int, int]]) -> int:
        return position([known[r.kind][r.number] for r in reads], self.model.sizes(reads))

    def _gain(self, known: dict[str, dict[int, int]]) -> float:
        return sum(gain.values[self._position(gain.reads, known)] for gain in self.model.rewards)
