# SPDX-License-Identifier: Apache-2.0
"""Small random models in Cassandra's format, and their values in exact rational arithmetic."""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction

Row = list[str]


@dataclass(frozen=True)
class SmallModel:
    """Decimals as they are written: ``moves[a][s][t]``, ``sights[a][t][o]``, ``rewards[a][s]``."""

    discount: str
    horizon: int
    start: Row
    moves: list[list[Row]]
    sights: list[list[Row]]
    rewards: list[Row]

    def text(self) -> str:
        """Return the model as a file in Cassandra's format, which has no horizon."""
        actions, states, sights = len(self.moves), len(self.start), len(self.sights[0][0])
        lines = [f"discount: {self.discount}", "values: reward", f"states: {states}"]
        lines += [f"actions: {actions}", f"observations: {sights}", f"start: {' '.join(self.start)}"]
        for a in range(actions):
            lines += [f"T: {a}", *map(" ".join, self.moves[a]), f"O: {a}", *map(" ".join, self.sights[a])]
            lines += [f"R: {a} : {s} : * : * {reward}" for s, reward in enumerate(self.rewards[a])]
        return "\n".join(lines) + "\n"

    def value(self) -> Fraction:
        """Return what the best policy is worth: every tree of actions and observations is tried."""
        return self._value([Fraction(p) for p in self.start], self.horizon)

    def _value(self, weights: list[Fraction], left: int) -> Fraction:
        if left == 0 or not any(weights):
            return Fraction(0)
        return max(self._action_value(a, weights, left) for a in range(len(self.moves)))

    def _action_value(self, a: int, weights: list[Fraction], left: int) -> Fraction:
        worth = sum((w * Fraction(r) for w, r in zip(weights, self.rewards[a], strict=True)), Fraction(0))
        after = [
            sum((w * Fraction(row[t]) for w, row in zip(weights, self.moves[a], strict=True)), Fraction(0))
            for t in range(len(weights))
        ]
        for o in range(len(self.sights[a][0])):
            seen = [w * Fraction(self.sights[a][t][o]) for t, w in enumerate(after)]
            worth += Fraction(self.discount) * self._value(seen, left - 1)
        return worth


def small_model(seed: int, least: int = 12) -> SmallModel:
    """Return a model of 2 to 4 states: rewards from 1e-9 to 1e9, probabilities down to 1e-``least``."""
    draw = random.Random(seed)
    states, actions, sights = draw.randint(2, 4), draw.randint(2, 3), draw.randint(2, 3)
    scale = draw.randint(-9, 8)

    def row(size: int) -> Row:
        parts = [draw.choice([draw.random(), 10.0 ** -draw.randint(1, least)]) for _ in range(size)]
        decimals = [Fraction(f"{part / sum(parts):.{least + 3}f}") for part in parts]
        likeliest = decimals.index(max(decimals))
        decimals[likeliest] += 1 - sum(decimals)
        return [f"{float(p * 10 ** (least + 3)):.0f}e-{least + 3}" for p in decimals]

    def reward() -> str:
        exponent = scale if draw.random() < 0.7 else draw.randint(-9, 8)
        return f"{draw.choice('-+').replace('+', '')}{draw.randint(1, 9999) / 1000}e{exponent}"

    return SmallModel(
        draw.choice(["0.9", "0.95", "0.5", "0.99"]),
        draw.randint(2, 4 if actions * sights < 7 else 3),
        row(states),
        [[row(states) for _ in range(states)] for _ in range(actions)],
        [[row(sights) for _ in range(states)] for _ in range(actions)],
        [[reward() for _ in range(states)] for _ in range(actions)],
    )
