# SPDX-License-Identifier: Apache-2.0
"""A particle filter that draws unread parts of a map anew comes to the exact posterior, others do not."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from support.belief_program import beliefs

from hypgen.codegen.generate import generate
from hypgen.dsl import load

pytestmark = pytest.mark.cxx
MODELS = Path(__file__).parent / "models"
CORRIDOR = MODELS / "corridor.pomdp"
PLACES, STEPS = 10, 480
DEPLETED, IMPOSSIBLE = 7, 8  # values of hypgen::Status
WET, GOES, FEELS = 0.3, {0: 0.7, 1: 0.95}, 0.95  # constants of the model


def exact(rows: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the probability that each cell is wet after each step, by Bayes' rule over all states."""
    maps = np.array(list(itertools.product((0, 1), repeat=PLACES)))
    start = np.zeros((PLACES, len(maps)))
    start[0] = np.prod(np.where(maps, WET, 1 - WET), axis=1)
    joint, result = start, []
    for status, action, felt in rows[:, :3].astype(int):
        ahead = np.concatenate([np.zeros_like(joint[:1]), joint[:-1]])
        ahead[-1] += joint[-1]
        moved = GOES[action] * ahead + (1 - GOES[action]) * joint
        joint = moved * np.where(felt == maps.T, FEELS, 1 - FEELS)
        joint = joint / joint.sum() if status == 0 else start
        result.append(joint.sum(axis=0) @ maps)
    return np.array(result)


def error(
    folder: Path, change: Callable[[str], str], particles: int, path: Path = CORRIDOR, first: int = 0
) -> float:
    """Return how far the particles are from the posterior of the map, on average.

    The map's cells are the variables from ``first`` on.
    """
    model = load.load(path).model
    header = change(next(t for name, t in generate(model).items() if name.endswith(".hpp")))
    rows = beliefs(header, model.name, "ParticleBelief", folder, particles, STEPS)
    goes_on = rows[:, 0] == 0
    wet = rows[:, 3:].reshape(STEPS, -1, 8)[:, first : first + PLACES, 1]
    return float(np.abs(wet - exact(rows))[goes_on].mean())


def kept(header: str) -> str:
    return header


def test_unread_cells_keep_their_prior(tmp_path: Path) -> None:
    def without(header: str) -> str:
        test = "if (site == Site::init_floor_wet) return static_cast<int>(index);"
        assert test in header
        return header.replace(test, "static_cast<void>(site + index);")

    assert error(tmp_path / "many", kept, 20_000) < 0.006
    assert error(tmp_path / "redrawn", kept, 1_000) < 0.6 * error(tmp_path / "copied", without, 1_000)


def test_many_words_of_other_values_do_not_displace_those_of_cells(tmp_path: Path) -> None:
    """The init of a crowd draws more words than a particle keeps, and comes before that of the floor."""
    text = CORRIDOR.read_text()
    crowd = """type Seat = 0 .. 89
element crowd {
  hidden sits: bool[Seat]
  init sits ~ [s in Seat: bernoulli(0.5)]
  sits' = [s in Seat: sits[s]]
}
"""
    path = tmp_path / "crowded.pomdp"
    path.write_text(text.replace("element floor", crowd + "element floor"))
    assert error(tmp_path / "crowded", kept, 500, path, first=90) < 0.035


def test_what_an_unread_value_depends_on_is_kept(tmp_path: Path) -> None:
    model = load.load(MODELS / "soil.pomdp").model
    header = next(t for path, t in generate(model).items() if path.endswith(".hpp"))
    rows = beliefs(header, model.name, "ParticleBelief", tmp_path / "soil", 5_000, 60)
    found = rows[rows[:, 0] == 0, 3:].reshape(-1, 13, 8)[:, :, 1]
    clay, wet, first = found[:, :5], found[:, 5:10], found[:, 10]
    assert clay.max() > 0.9
    assert (first == wet[:, 0]).all()
    assert np.abs(wet - (0.05 + 0.9 * clay)).max() < 0.05  # as nothing else is known of it


def test_copies_that_drew_anew_are_one_hypothesis(tmp_path: Path) -> None:
    """A belief is said to be depleted although all its particles have different maps.

    Each has a code of 100 that its observations tell. Where copies of the codes that are left contradict what
    was seen, codes have been lost, so the observation is not impossible by the model.
    """
    text = CORRIDOR.read_text()
    told = "if act == stay then robot.code % 2 == 0 else robot.code // 2 % 2 == 0"
    code = "hidden fixed code: 0 .. 99\n  init code ~ uniform(0, 99)\n  hidden x"
    text = text.replace("hidden x", code).replace(
        "observe feels", f"observe told: bool ~ {told}\nobserve feels"
    )
    text = text.replace("reward dry", "observe tens: 0 .. 9 ~ robot.code // 10\nreward dry")
    text = text.replace("noisy(floor.wet[robot.x'], 0.95)", "floor.wet[robot.x']")
    text = text.replace("if act == go then 0.95 else 0.7", "if act == go then 1 else 0")
    text = text.replace("type Place = 0 .. 9", "type Place = 0 .. 99")
    path = tmp_path / "codes.pomdp"
    path.write_text(text)
    model = load.load(path).model
    header = next(t for name, t in generate(model).items() if name.endswith(".hpp"))
    # Moves find the codes that explain what was seen, unless there are very few particles.
    status = beliefs(header, model.name, "ParticleBelief", tmp_path / "codes", 3, 600)[:, 0]
    first = np.concatenate([[True], status[:-1] != 0])  # in an episode: nothing has been lost yet
    assert IMPOSSIBLE in status[first]
    assert DEPLETED in status[~first]
    assert IMPOSSIBLE not in status[~first]
    assert DEPLETED not in status[first]
