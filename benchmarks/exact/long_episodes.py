# SPDX-License-Identifier: Apache-2.0
"""Solves small models at a discount of 0.99999 and prints how long that takes, as a table in Markdown.

python3 benchmarks/exact/long_episodes.py [--time 10]

The models: the tiger, a machine that wears out, a noisy line, and random ones of 2 to 10 states.
"""

from __future__ import annotations

import argparse
import random
import tempfile
from pathlib import Path

from corpus import solve

Rows = list[list[float]]
RANDOM = ((1, 2, 2, 2), (2, 3, 3, 2), (3, 5, 3, 3), (4, 8, 4, 3), (5, 10, 3, 4))  # seed, sizes


def cassandra(steps: list[Rows], sights: list[Rows], rewards: Rows) -> str:
    """Return a model's file in Cassandra's format: tables by action."""
    sizes = f"states: {len(steps[0])}\nactions: {len(steps)}\nobservations: {len(sights[0][0])}\n"
    lines = ["discount: 0.99999\nvalues: reward\n" + sizes]
    for action, (step, sight, reward) in enumerate(zip(steps, sights, rewards, strict=True)):
        for kind, rows in (("T", step), ("O", sight)):
            lines.append(f"{kind}: {action}")
            lines += [" ".join(f"{p:.6f}" for p in row) for row in rows]
        lines += [f"R: {action} : {state} : * : * {value}" for state, value in enumerate(reward)]
    return "\n".join(lines) + "\n"


def row(weights: list[float]) -> list[float]:
    """Return probabilities with six digits that sum to 1."""
    result = [round(w / sum(weights), 6) for w in weights]
    result[result.index(max(result))] += 1 - sum(result)
    return result


def random_model(seed: int, states: int, actions: int, sights: int) -> str:
    """Return a model whose every step leads everywhere."""
    chance = random.Random(seed)
    steps = [
        [row([chance.random() ** 3 for _ in range(states)]) for _ in range(states)] for _ in range(actions)
    ]
    seen = [
        [row([chance.random() ** 2 + 0.02 for _ in range(sights)]) for _ in range(states)]
        for _ in range(actions)
    ]
    return cassandra(
        steps, seen, [[round(chance.uniform(-1, 1), 3) for _ in range(states)] for _ in range(actions)]
    )


def models() -> dict[str, str]:
    """Return the files by name."""
    even = [[0.5, 0.5]] * 2
    heard = [[0.85, 0.15], [0.15, 0.85]]
    tiger = cassandra([[[1, 0], [0, 1]], even, even], [heard, even, even], [[-1, -1], [-100, 10], [10, -100]])
    wear = [[0.95, 0.05, 0, 0], [0, 0.95, 0.05, 0], [0, 0, 0.95, 0.05], [0, 0, 0, 1]]
    blind = [[0.5, 0.5]] * 4
    look = [[0.95, 0.05], [0.8, 0.2], [0.3, 0.7], [0.05, 0.95]]
    machine = cassandra(
        [wear, wear, [[1, 0, 0, 0]] * 4],
        [blind, look, blind],
        [[1, 0.9, 0.6, 0], [0.9, 0.8, 0.5, -0.1], [-4] * 4],
    )
    steps = []
    for by in (1, -1, 3):
        rows = [[0.0] * 10 for _ in range(9)]
        for state, weights in enumerate(rows):
            weights[min(max(state + by, 0), 9)] += 0.8
            weights[state] += 0.2
        steps.append([row(weights) for weights in [*rows, [1 / 9] * 9 + [0]]])
    sight = [
        row([0.05 + 0.85 * (n == (0 if s == 9 else 1 if s % 3 == 0 else 2)) for n in range(3)])
        for s in range(10)
    ]
    line = cassandra(steps, [sight] * 3, [[0] * 9 + [1], [0] * 9 + [1], [-0.1] * 9 + [1]])
    found = {"tiger": tiger, "machine": machine, "line": line}
    return found | {f"random, {sizes[1]} states": random_model(*sizes) for sizes in RANDOM}


def main() -> None:
    """Solve the models and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--time", type=float, default=10.0, help="seconds for each model (10)")
    asked = parser.parse_args()
    print("| model | states | lower | upper | gap | seconds |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, text) in enumerate(models().items()):
            file = Path(folder) / f"long_{number}.POMDP"
            file.write_text(text, encoding="utf-8")
            found = solve(file, asked.time, 1e-3)
            low, high = found["lower"], found["upper"]
            gap = (high - low) / max(abs(low), abs(high), 1)
            ends = f"{low:.7g} | {high:.7g} | {gap:.1e}"
            print(f"| {name} | {found['states']} | {ends} | {found['seconds']:.2f} |", flush=True)


if __name__ == "__main__":
    main()
