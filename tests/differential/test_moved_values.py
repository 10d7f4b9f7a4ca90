# SPDX-License-Identifier: Apache-2.0
"""A particle filter that moves hidden values one by one comes to the exact posterior."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from support.belief_program import beliefs

from hypgen.codegen.generate import generate
from hypgen.dsl import load

pytestmark = pytest.mark.cxx
MINES = Path(__file__).parent / "models" / "mines.pomdp"
PLACES, MINES_IN_ALL, STEPS = 8, 3, 480
RIGHT = 0.8  # a constant of the model


def law(places: tuple[int, ...]) -> float:
    """Return how probable the mines' places are at the start."""
    chance = 1.0
    for mine in range(MINES_IN_ALL):
        free = [p for p in range(PLACES) if all(abs(p - places[n]) > n + 1 for n in range(mine))]
        chance *= (places[mine] in free) / len(free) if free else places[mine] == 0
    return chance


def exact(rows: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the probability of each place of each mine after each step, by Bayes' rule over all places."""
    all_places = np.array(list(itertools.product(range(PLACES), repeat=MINES_IN_ALL)))
    start = np.array([law(tuple(places)) for places in all_places])
    held, result = start, []
    for status, probe, key in rows[:, :3].astype(int):
        count = (abs(all_places - probe) <= 1).sum(axis=1)
        last = (all_places[:, 2] < probe) == (key % 2 != 0)
        held = held * (count == key // 2) * np.where(last, RIGHT, 1 - RIGHT)
        held = held / held.sum() if status == 0 else start
        result.append(
            [[held[all_places[:, m] == p].sum() for p in range(PLACES)] for m in range(MINES_IN_ALL)]
        )
    return np.array(result)


def error(folder: Path, particles: int, moves: bool) -> float:
    """Return the root of the mean square by which particles are off the posterior."""
    model = load.load(MINES).model
    header = next(text for name, text in generate(model).items() if name.endswith(".hpp"))
    assert "kHiddenValues" in header
    if not moves:
        header = header.replace("kHiddenValues", "kStayingValues")
    rows = beliefs(header, model.name, "ParticleBelief", folder, particles, STEPS)
    goes_on = rows[:, 0] == 0
    found = rows[:, 3:].reshape(STEPS, -1, PLACES)[:, :MINES_IN_ALL]
    return float(np.sqrt(np.square(found - exact(rows))[goes_on].mean()))


def test_values_that_move_come_to_the_posterior(tmp_path: Path) -> None:
    few, many = error(tmp_path / "few", 100, True), error(tmp_path / "many", 10_000, True)
    assert many < 0.006
    assert few < 0.05
    assert few < 0.7 * error(tmp_path / "stays", 100, False)
