# SPDX-License-Identifier: Apache-2.0
"""What a Markov chain earns for ever: linear equations, solved by taking out one state after the other."""

from __future__ import annotations

from collections.abc import Sequence

Row = Sequence[tuple[int, float]]  # (next state, probability); what is missing to 1 ends the chain


def values(rows: Sequence[Row], gains: Sequence[float], discount: float, work: int) -> list[float] | None:
    """Return what is earned from each state; None if that takes more than ``work`` products.

    With a discount of 1 each state has to reach an end (``all_end``).
    """
    shortest = min(map(len, rows), default=0)
    if shortest**3 > 3 * work:  # rows only grow while states are taken out
        return None
    weights: list[dict[int, float]] = []
    before: list[set[int]] = [set() for _ in rows]
    for state, row in enumerate(rows):
        weights.append({})
        for following, probability in row:
            if probability > 0:
                weights[state][following] = weights[state].get(following, 0.0) + discount * probability
                before[following].add(state)
    result = list(gains)
    order = sorted(range(len(rows)), key=lambda s: len(weights[s]) * len(before[s]))
    for state in order:
        own = weights[state]
        stays = 1.0 - own.pop(state, 0.0)
        before[state].discard(state)
        for following in own:
            own[following] /= stays
            before[following].discard(state)
        result[state] /= stays
        work -= len(own) * (len(before[state]) + 1)
        if work < 0:
            return None
        for other in before[state]:
            weight = weights[other].pop(state)
            result[other] += weight * result[state]
            for following, share in own.items():
                weights[other][following] = weights[other].get(following, 0.0) + weight * share
                before[following].add(other)
    for state in reversed(order):
        result[state] += sum(w * result[following] for following, w in weights[state].items())
    return result


def all_end(rows: Sequence[Row]) -> bool:
    """Return whether every state can reach one from which the chain may end."""
    before: list[list[int]] = [[] for _ in rows]
    for state, row in enumerate(rows):
        for following, probability in row:
            if probability > 0:
                before[following].append(state)
    met = [s for s, row in enumerate(rows) if sum(p for _, p in row) < 1 - 1e-12]
    known = set(met)
    for state in met:  # grows
        new = [s for s in before[state] if s not in known]
        known.update(new)
        met += new
    return len(known) == len(rows)
