# SPDX-License-Identifier: Apache-2.0
"""The best policy that always does the same: a first lower bound, better than acting at random."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hypgen.dsl.foreign.tables.foreign_model import (
    ForeignModel,
    Law,
    Read,
    combinations,
    count,
    drawing_order,
    position,
)

_MOST_STATES = 20_000
_MOST_WORK = 1_000_000  # products of a probability and a value: half a second
_ENOUGH = 1e-4


@dataclass(frozen=True)
class Blind:
    """An action, a value for each action variable, and what it earns from the start."""

    action: tuple[int, ...]
    value: float


def best_blind(model: ForeignModel, horizon: int | None) -> Blind | None:
    """Return the best of the fixed actions; None where the states are too many to tell."""
    actions = [v.size for v in model.actions]
    states = [v.size for v in model.states]
    if count(states) > _MOST_STATES or count(states) * count(actions) > 10 * _MOST_STATES:
        return None
    flat = _Flat(model, states)
    found: list[Blind] = []
    for action in combinations(actions):
        values = flat.evaluate(action, horizon, _MOST_WORK // count(actions))
        if values is None:
            return None
        found.append(Blind(action, sum(p * values[s] for s, p in flat.start)))
    return max(found, key=lambda b: b.value)


class _Flat:
    """The product of all state variables, one action at a time."""

    def __init__(self, model: ForeignModel, sizes: list[int]) -> None:
        self.model, self.sizes = model, sizes
        self.start = self._joint(model.starts, "state", {})
        self.following: list[dict[int, int]] = []  # the values of the variables, by state
        for state in combinations(sizes):
            self.following.append(dict(enumerate(state)))

    def evaluate(self, action: tuple[int, ...], horizon: int | None, work: int) -> list[float] | None:
        """Return the value of each state under ``action`` for ever; None if that takes too long."""
        rows: list[list[tuple[int, float]]] = []
        gains: list[float] = []
        entries = 0
        for values in self.following:
            known = {"action": dict(enumerate(action)), "state": values}
            row = self._joint(self.model.transitions, "next", known)
            entries += len(row)
            if entries > work:
                return None
            rows.append(row)
            gains.append(sum(p * self._gain({**known, "next": self.following[n]}) for n, p in row))
        gamma, earned, steps = self.model.discount, gains, 1
        most = min(horizon or work, work // max(entries, 1))
        size = max(map(abs, gains), default=0.0)
        while size * gamma**steps > _ENOUGH and steps < most:
            earned = [g + gamma * sum(p * earned[n] for n, p in r) for g, r in zip(gains, rows, strict=True)]
            steps += 1
        return earned

    def _joint(
        self, laws: Sequence[Law], kind: str, known: dict[str, dict[int, int]]
    ) -> list[tuple[int, float]]:
        """Return a joint law of all variables; reads of ``kind`` are of those drawn before."""
        partial: list[tuple[dict[int, int], float]] = [({}, 1.0)]
        for number in drawing_order(laws, kind):
            extended = []
            for given, probability in partial:
                row = laws[number].rows[self._position(laws[number].reads, {**known, kind: given})]
                extended += [({**given, number: v}, probability * p) for v, p in row]
            partial = extended
        numbers = range(len(self.sizes))
        return [(position([given[n] for n in numbers], self.sizes), p) for given, p in partial]

    def _position(self, reads: Sequence[Read], known: dict[str, dict[int, int]]) -> int:
        return position([known[r.kind][r.number] for r in reads], self.model.sizes(reads))

    def _gain(self, known: dict[str, dict[int, int]]) -> float:
        return sum(gain.values[self._position(gain.reads, known)] for gain in self.model.rewards)
