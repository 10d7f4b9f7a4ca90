# SPDX-License-Identifier: Apache-2.0
"""The interval of ``hypgen solve`` holds the value of the text in exact rational arithmetic.

Each model is compiled, which takes seconds. ``pytest -m slow tests/e2e/test_proven.py`` tries 500.
"""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest
from support.exact_pomdps import small_model

pytestmark = pytest.mark.cxx
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
# The least probability is 10 to the power of minus this.
LEAST = 12


def misses(seed: int, folder: Path) -> str:
    """Return what is wrong with the interval of a model; empty if nothing is."""
    model = small_model(seed, LEAST)
    written, imported = folder / f"m{seed}.POMDP", folder / f"m{seed}.pomdp"
    written.write_text(model.text())
    steps = ("--horizon", str(model.horizon), "-o", str(imported))
    done = subprocess.run([*HYPGEN, "import", str(written), *steps], capture_output=True, text=True)
    if done.returncode != 0:
        return f"seed {seed}: {done.stderr}"
    command = [*HYPGEN, "solve", str(imported), "--json", "--time", "10"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        return f"seed {seed}: {done.stderr}"
    found, value = json.loads(done.stdout), model.value()
    if Fraction(found["lower"]) <= value <= Fraction(found["upper"]):
        return ""
    return f"seed {seed}: {float(value)!r} is not within {found['lower']!r} .. {found['upper']!r}"


def test_intervals_of_random_models_hold_their_exact_values(tmp_path: Path) -> None:
    assert [found for seed in range(6) if (found := misses(seed, tmp_path))] == []


@pytest.mark.slow
def test_intervals_of_many_random_models_hold_their_exact_values(tmp_path: Path) -> None:
    assert [found for seed in range(500) if (found := misses(seed, tmp_path))] == []
