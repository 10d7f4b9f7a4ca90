# SPDX-License-Identifier: Apache-2.0
"""The best policy that always does the same: a first lower bound, better than acting at random."""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.dsl.foreign.tables.foreign_model import ForeignModel, combinations, count
from hypgen.dsl.foreign.writer import equations
from hypgen.dsl.foreign.writer.flat_model import FlatModel

_MOST_STATES = 20_000
_MOST_WORK = 1_000_000  # products of a probability and a value: half a second
# What an action may be worth is known well enough when the ends differ by less than this part of them.
_ENOUGH = 1e-5
_ROUNDING = 1e-9  # of values: no action is better by that


@dataclass(frozen=True)
class Blind:
    """An action, a value for each action variable, and what it earns from the start."""

    action: tuple[int, ...]
    value: float


def best_blind(model: ForeignModel, horizon: int | None) -> Blind | None:
    """Return the best of the fixed actions; None where the states are too many to tell."""
    actions = [v.size for v in model.actions]
    states = count([v.size for v in model.states])
    if states > _MOST_STATES or states * count(actions) > 10 * _MOST_STATES:
        return None
    flat = FlatModel(model)
    found: list[tuple[float, float, tuple[int, ...]]] = []
    for action in combinations(actions):
        ends = _value(flat, action, horizon, _MOST_WORK // count(actions))
        if ends is None:
            return None
        found.append((*ends, action))
    # Of actions that cannot be told apart the first: the one that is surely worth as much as any other.
    most = max(low for low, _, _ in found)
    low, high, action = next(f for f in found if f[0] >= most - _ROUNDING * abs(most))
    return Blind(action, 0.5 * (low + high))


def _value(
    flat: FlatModel, action: tuple[int, ...], horizon: int | None, work: int
) -> tuple[float, float] | None:
    """Return between what the action earns from the start, if it is taken for ever."""
    steps = flat.reached(action, work)
    if steps is None:
        return None
    number = {state: n for n, state in enumerate(steps)}
    rows = [[(number[n], p) for n, p in row] for row, _ in steps.values()]
    gains = [gain for _, gain in steps.values()]
    start = [(number[s], p) for s, p in flat.start]
    discount = flat.model.discount
    exact = None if horizon is not None else equations.values(rows, gains, discount, work)
    if exact is not None:
        value = sum(p * exact[s] for s, p in start)
        return value, value
    return _swept(rows, gains, start, discount, horizon, work)


def _swept(
    rows: list[list[tuple[int, float]]],
    gains: list[float],
    start: list[tuple[int, float]],
    discount: float,
    horizon: int | None,
    work: int,
) -> tuple[float, float]:
    """Return the ends by sweeps: a change of all states by as much or more goes on like that for ever."""
    most = max(work // max(sum(map(len, rows)), 1), 1)
    if horizon is not None:
        most = min(most, horizon)
    earned, low, high = gains, 0.0, 0.0
    for step in range(1, most + 1):
        later = [g + discount * sum(p * earned[n] for n, p in r) for g, r in zip(gains, rows, strict=True)]
        value = sum(p * earned[s] for s, p in start)
        if horizon is not None:
            low = high = value
        else:
            changes = [b - a for a, b in zip(earned, later, strict=True)]
            low, high = (value + end / (1 - discount) for end in (min(changes), max(changes)))
            if high - low <= _ENOUGH * max(abs(low), abs(high)):
                break
        if step < most:
            earned = later
    return low, high
