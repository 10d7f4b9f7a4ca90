# SPDX-License-Identifier: Apache-2.0
"""Compiles ``filters.cpp`` for a model, and runs it."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hypgen.codegen.generate import generate_exact
from hypgen.dsl import load
from hypgen.runtime.builder.solver import EXACT_MAIN, build_solver

HERE = Path(__file__).parent


def build(model: Path, settings: Sequence[str] = ()) -> Path:
    """Return the program that compares beliefs of a model with the exact one."""
    loaded = load.load(model, settings=tuple(settings))
    files = generate_exact(loaded.model)
    beginning, _, _ = files[EXACT_MAIN].partition("int main(")
    files[EXACT_MAIN] = beginning + (HERE / "filters.cpp").read_text(encoding="utf-8")
    return build_solver(files, f"{model} filters", lambda step: None)


def compare(
    program: Path, kind: str, particles: int, *, episodes: int, steps: int, seed: int
) -> dict[str, Any]:
    """Return what ``filters.cpp`` prints."""
    command = [program, kind, particles, episodes, steps, seed]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True)
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def slope(points: Sequence[tuple[float, float]]) -> float:
    """Return the slope of the line through the logarithms, by least squares."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    x_mean, y_mean = sum(xs) / len(xs), sum(ys) / len(ys)
    covariance = sum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys, strict=True))
    return covariance / sum((x - x_mean) ** 2 for x in xs)


def chi_square(counts: Sequence[int]) -> float:
    """Return how far counts are from equal ones: chi-square with one degree of freedom less than counts."""
    expected = sum(counts) / len(counts)
    return sum((count - expected) ** 2 for count in counts) / expected
