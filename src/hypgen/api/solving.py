# SPDX-License-Identifier: Apache-2.0
"""The value of a small model's best policy, between proven bounds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypgen.api.model import Model
from hypgen.api.programs import Progress
from hypgen.play.played_programs import lines_of


@dataclass(frozen=True)
class Solution:
    """What is proven of the value of the best policy.

    ``status`` is ``converged``, or says which limit came first. ``details`` has all that
    `hypgen solve --json` prints.
    """

    lower: float
    upper: float
    status: str
    best_action: str
    seconds: float
    details: dict[str, Any]


def solve(
    model: Model,
    *,
    time: float = 60.0,
    gap: float = 1e-3,
    memory: int = 4096,
    policy: Path | None = None,
    progress: Progress | None = None,
) -> Solution:
    """Bound the value of a model's best policy from both sides.

    The search ends when the bounds are within ``gap`` of each other, relative to the value's size, or after
    ``time`` seconds. ``memory`` is in MiB. ``policy`` is a file for the policy that was found. A model whose
    draws have too many values raises ``ModelError``, and one that is too large ``RuntimeError``.
    """
    program = model.program("precise", progress=progress)
    options = [f"--time={time!r}", f"--gap={gap!r}", f"--memory={memory}"]
    options += [] if policy is None else [f"--policy={policy}"]
    lines = lines_of([str(program), *options, "--json=-", "--quiet"])
    found = next(line for line in lines if line["type"] == "solve")
    for _ in lines:  # to its end, where a failure is told
        pass
    return Solution(
        found["lower"], found["upper"], found["status"], found["best_action"], found["seconds"], found
    )
