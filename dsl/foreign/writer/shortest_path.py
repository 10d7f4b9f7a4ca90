# SPDX-License-Identifier: Apache-2.0
"""Models without discount and horizon whose episodes the model ends: stochastic shortest paths.

Values are finite where every policy that never ends costs without bound. Policy iteration tells: it stays
with policies that end, even if each step is paid a little.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.dsl.foreign.tables.foreign_model import ForeignModel, combinations, count
from hypgen.dsl.foreign.writer import equations
from hypgen.dsl.foreign.writer.flat_model import FlatModel, Row

_MOST_ROWS = 5_000  # of states and actions
_MOST_WORK = 10_000_000  # products: some seconds
_SLACK = 1e-6  # of bounds, which are float32 in the text
_TRIES = 12


@dataclass(frozen=True)
class Paths:
    """The best fixed action (None: acting at random) and its value; bounds of values in all states."""

    action: tuple[int, ...] | None
    value: float
    upper: float
    tail: float


def shortest_paths(model: ForeignModel) -> Paths | str:
    """Return the bounds of a model with a discount of 1, or why it has none."""
    actions = list(combinations([v.size for v in model.actions]))
    states = count([v.size for v in model.states])
    if states * len(actions) > _MOST_ROWS:
        return "the model is too large to prove that every policy ends"
    flat = FlatModel(model)
    steps = [[flat.step(action, state) for state in range(states)] for action in actions]
    free = _free_states(steps)
    number = {s: n for n, s in enumerate(s for s in range(states) if s not in free)}
    chains = [
        ([[(number[n], p) for n, p in of[s][0] if n in number] for s in number], [of[s][1] for s in number])
        for of in steps
    ]
    random = _mixed(chains)
    if not equations.all_end(random[0]):
        return "from some state no action ever leads to an end"
    earned = _values(random)
    if earned is None:
        return "the model is too large to prove that every policy ends"
    size = max((abs(g) for _, gains in chains for g in gains), default=0.0)
    if not any(_best(chains, size * 0.25**n * 0.5) for n in range(_TRIES)) and size:
        return "a policy that never ends costs nothing in the long run"
    best = _best(chains, 0.0) or earned
    found: list[tuple[list[float], tuple[int, ...] | None]] = [(earned, None)]
    for action, chain in zip(actions, chains, strict=True):
        if equations.all_end(chain[0]) and (values := _values(chain)) is not None:
            found.append((values, action))
    start = [(number[s], p) for s, p in flat.start if s in number]
    own = [(sum(p * values[s] for s, p in start), values, action) for values, action in found]
    value, values, chosen = max(own[1:] or own, key=lambda o: o[0])
    slack = _SLACK * max(map(abs, [*best, *values]), default=0.0)
    return Paths(chosen, value, max([0.0, *best]) + slack, min([0.0, *values]) - slack)


def _free_states(steps: list[list[tuple[Row, float]]]) -> set[int]:
    """Return the states that are never left and earn nothing, whatever is done."""
    free = {s for s in range(len(steps[0])) if all(of[s][1] == 0 for of in steps)}
    while True:
        left = {s for s in free if any(n not in free for of in steps for n, _ in of[s][0])}
        if not left:
            return free
        free -= left


Chain = tuple[list[Row], list[float]]


def _mixed(chains: list[Chain]) -> Chain:
    """Return the chain of acting at random."""
    share = 1 / len(chains)
    states = range(len(chains[0][0]))
    rows = [[(n, share * p) for rows, _ in chains for n, p in rows[s]] for s in states]
    return rows, [share * sum(gains[s] for _, gains in chains) for s in states]


def _values(chain: Chain) -> list[float] | None:
    return equations.values(*chain, 1.0, _MOST_WORK)


def _best(chains: list[Chain], bonus: float) -> list[float] | None:
    """Return the values of the best policy that sees the state, each step paid; None if it never ends."""
    paid = [(rows, [g + bonus for g in gains]) for rows, gains in chains]
    chain = _mixed(paid)
    chosen: list[int] = []
    while equations.all_end(chain[0]) and (values := _values(chain)) is not None:
        better = 1e-12 * max(map(abs, values), default=0.0)
        new = []
        for state in range(len(values)):
            worth = [gains[state] + sum(p * values[n] for n, p in rows[state]) for rows, gains in paid]
            best = max(range(len(worth)), key=worth.__getitem__)
            is_best = bool(chosen) and worth[chosen[state]] >= worth[best] - better
            new.append(chosen[state] if is_best else best)
        if new == chosen:
            return values
        chosen = new
        states = range(len(chosen))
        chain = ([paid[chosen[s]][0][s] for s in states], [paid[chosen[s]][1][s] for s in states])
    return None
