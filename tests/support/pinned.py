# SPDX-License-Identifier: Apache-2.0
"""Searches whose trees are pinned: their options, and the table of their signatures."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from .paths import ROOT

PINS: dict[str, dict[str, str]] = json.loads(
    (ROOT / "tests" / "e2e" / "pinned_signatures.json").read_text(encoding="utf-8")
)
SEARCH = ("--runs", "2", "--steps", "3", "--trials", "60", "--scenarios", "50", "--depth", "20")
# 529 actions, each with a rollout for each scenario of a leaf.
SMALL_SEARCH = ("--runs", "1", "--steps", "2", "--trials", "8", "--scenarios", "10", "--depth", "12")
LARGE = {"two_robot_rock_sample"}
VARIANTS = {
    "F 1": ("--in-flight", "1"),
    "F 16": ("--in-flight", "16"),
    "F 16, lambda 0.05": ("--in-flight", "16", "--pruning", "0.05"),
}
# A few: many actions, observations or scenarios a leaf, and none of these.
EXPLORING = {"laser_tag", "navigation", "rock_sample", "tiger"}
EXPLORING_VARIANTS = {
    "F 1, c_a 0.3": ("--in-flight", "1", "--exploration", "0.3"),
    "F 16, c_a 0.3": ("--in-flight", "16", "--exploration", "0.3"),
}


def signatures(solver: Path, example: str) -> dict[str, str]:
    """Return the signatures of an example's searches, as the table has them."""
    search = SMALL_SEARCH if example in LARGE else SEARCH
    variants = VARIANTS | (EXPLORING_VARIANTS if example in EXPLORING else {})
    return {name: _signature(solver, (*search, *options)) for name, options in variants.items()}


def _signature(solver: Path, options: tuple[str, ...]) -> str:
    """Return the hash over all trees of a run."""
    command = [str(solver), "--mode", "despot", *options, "--seed", "5", "--signature", "--quiet"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout.removeprefix("signature ").strip()
