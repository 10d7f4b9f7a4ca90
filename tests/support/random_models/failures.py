# SPDX-License-Identifier: Apache-2.0
"""Compares random models by seed, and makes those that fail small.

PYTHONPATH=tests python -m support.random_models.failures FIRST LAST    prints what fails of these seeds

Put a model that failed into tests/differential/found, where it stays as a test.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from support.random_models import batches, generator
from support.random_models.tree import Node, shrink

BATCH = 20
# What constants may come to: arms that never occur, values that never fit, empty sets, zero divisors.
UNLUCKY = frozenset({"E0307", "E0601", "E0603", "E0605", "E0608", "E0612", "E0707"})
SLOW = 3_000


def failure(result: str | None) -> str:
    """Return what kind of failure a comparison found; nothing where there is none."""
    if result is None:
        return ""
    if result.startswith("refused"):
        return ": ".join(result.split(": ")[:2])
    return result.partition(" in row")[0].partition(":")[0]


def failures(seeds: Sequence[int], size: batches.Size, workers: int = 2) -> Iterator[str]:
    """Compare the models of ``seeds``; yield each that fails in a small form, with what is wrong with it."""
    groups = [seeds[i : i + BATCH] for i in range(0, len(seeds), BATCH)]
    with ThreadPoolExecutor(workers) as pool:
        for group, results in zip(groups, pool.map(lambda g: _compare_seeds(g, size), groups), strict=True):
            for seed, result in zip(group, results, strict=True):
                if failure(result):
                    yield f"seed {seed}:\n{_small(accepted(seed), failure(result), size)}"


def accepted(seed: int) -> Node:
    """Return the first model of a seed that has no mistake by bad luck and is not slow to compare."""
    for attempt in range(20):
        model = generator.model(seed, attempt)
        result = batches.lowered(str(model), 0)
        if isinstance(result, str):
            unlucky = result.startswith("refused") and result.split(": ")[1] in UNLUCKY
        else:
            # A posterior takes the square of its joint values in every step, in Python.
            unlucky = sum(f.size**2 * f.members for f in result.factors if f.exact) > SLOW
        if not unlucky:
            return model
    raise AssertionError(f"seed {seed}: no model is accepted")


def _compare_seeds(seeds: Sequence[int], size: batches.Size) -> list[str | None]:
    return _compare([accepted(seed) for seed in seeds], size)


def _compare(models: Sequence[Node], size: batches.Size) -> list[str | None]:
    with tempfile.TemporaryDirectory() as folder:
        return batches.compare([str(model) for model in models], Path(folder), size)


def _small(model: Node, kind: str, size: batches.Size) -> str:
    def failing(candidates: Sequence[Node]) -> Node | None:
        results = _compare(candidates, size)
        return next((c for c, r in zip(candidates, results, strict=True) if failure(r) == kind), None)

    small = shrink(model, failing)
    lines = [line for line in str(small).splitlines() if line.strip()]
    return "\n".join([*lines, "", str(_compare([small], size)[0])])


def main() -> None:
    """Compare the models of a range of seeds."""
    first, last = int(sys.argv[1]), int(sys.argv[2])
    at_once = 2 * BATCH  # a batch for each of the workers
    for start in range(first, last, at_once):
        end = min(start + at_once, last)
        for report in failures(range(start, end), batches.Size()):
            print(report, flush=True)
        print(f"seeds {first} to {end - 1} are compared", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
