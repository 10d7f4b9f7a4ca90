# SPDX-License-Identifier: Apache-2.0
"""Our filters against the exact one, on RockSample(4,4): one build serves all tests.

benchmarks/exact/filters.py does the same at length; docs/results/exact.md has what it gives.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import filter_program
import pytest

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
ROCKS = ("n=4", "k=4", "start_row=2", "rock_x=[3,2,1,1]", "rock_y=[1,1,3,0]")
CHI_SQUARE_9 = 27.88  # exceeded by one in a thousand of calibrated beliefs

Compare = Callable[..., dict[str, Any]]


# What is seen at the start tells of each bot on its own, of the one that a mast is turned to, and of all.
FIRST_LOOK = """
model Glance
type Bot = 1 .. 2
type Spot = 0 .. 9
discount 0.9
action look: Bot
element mast {
  visible fixed turned: Bot
  init turned ~ uniform(Bot)
  observe far: Spot at start ~ noisy(bot[turned].at, 0.6)
  observe high: bool[Bot] at start ~ [b in Bot: noisy(bot[b].at > 4, 0.7)]
}
element bot[b in Bot] {
  hidden at: Spot
  init at ~ uniform(s in Spot where s >= b: s)
  at' ~ { at: 0.7, else clamp(at + 1) }
  observe lit: bool at start ~ bernoulli(0.1 * at)
}
observe seen: Spot ~ noisy(bot[look].at', 0.5)
reward none = look - 1
"""

# No product: a hidden place on a map. Copies of particles draw anew the cells that nothing seen has read.
FIRST_LOOK_AT_MAP = """
model Marsh
type Cell = 0 .. 4
discount 0.9
action go: bool
element floor {
  hidden fixed wet: bool[Cell]
  init wet ~ [c in Cell: bernoulli(0.3)]
  observe smell: bool at start ~ noisy(wet[0] or wet[1], 0.8)
}
element robot {
  hidden at: Cell
  init at ~ uniform(Cell)
  at' ~ if go then { clamp(at + 1): 0.8, else at } else at
  observe damp: bool at start ~ noisy(floor.wet[at], 0.9)
}
observe feels: bool ~ noisy(floor.wet[robot.at'], 0.9)
reward none = if go then 1 else 0
"""

# Two that follow each other make one unit, beside a lamp that is none of their business.
PAIR = """
model Pair
type Bot = 0 .. 1
type Spot = 0 .. 5
enum Act { wait, look }
discount 0.9
action act: Act
element bot[b in Bot] {
  hidden at: Spot
  init at ~ uniform(Spot)
  at' ~ { at: 0.6, else clamp(at + (if bot[1 - b].at > at then 1 else -1)) }
}
element lamp {
  hidden on: bool
  init on ~ bernoulli(0.3)
  on' ~ noisy(on, 0.9)
  observe glow: bool ~ noisy(on', 0.8)
}
observe close: bool ~ noisy(bot[0].at' == bot[1].at', 0.9)
observe seen: Spot ~ if act == look then noisy(bot[0].at', 0.6)
                     else noisy((if lamp.on' then 5 else 0), 0.7)
reward none = if act == look then 1 else 0
"""


def at_start(path: Path, text: str) -> Compare:
    """Return how to compare beliefs of a model with a first observation with the exact one."""
    path.write_text(text)
    program = filter_program.build(path)

    def run(kind: str, particles: int, episodes: int, steps: int = 0) -> dict[str, Any]:
        result = filter_program.compare(program, kind, particles, episodes=episodes, steps=steps, seed=1)
        assert result["updates"] == max(steps, 1) * episodes and result["failures"] == 0
        return result

    return run


@pytest.fixture(scope="module")
def compare_start(tmp_path_factory: pytest.TempPathFactory) -> Compare:
    return at_start(tmp_path_factory.mktemp("model") / "glance.pomdp", FIRST_LOOK)


@pytest.fixture(scope="module")
def compare_map(tmp_path_factory: pytest.TempPathFactory) -> Compare:
    return at_start(tmp_path_factory.mktemp("model") / "marsh.pomdp", FIRST_LOOK_AT_MAP)


@pytest.fixture(scope="module")
def compare_pair(tmp_path_factory: pytest.TempPathFactory) -> Compare:
    return at_start(tmp_path_factory.mktemp("model") / "pair.pomdp", PAIR)


@pytest.fixture(scope="module")
def compare() -> Compare:
    """Return how to compare a belief with the exact one: kind, particles and episodes."""
    program = filter_program.build(ROOT / "examples" / "rock_sample.pomdp", ROCKS)

    def run(kind: str, particles: int, episodes: int) -> dict[str, Any]:
        result = filter_program.compare(program, kind, particles, episodes=episodes, steps=12, seed=1)
        assert result["updates"] > 0.9 * 12 * episodes and result["failures"] == 0
        return result

    return run


def test_infinitely_many_particles_would_be_exact(compare: Compare) -> None:
    assert compare("limit", 1, 300)["largest"] < 1e-9


def test_the_factored_filter_is_exact(compare: Compare) -> None:
    # 1e-6 is what is promised, after 50 steps too. A probability near 1 has lost digits of what it lacks of
    # 1: as floats these 12 steps would lose 1e-6, as doubles 1e-14.
    assert compare("factored", 1, 300)["largest"] < 1e-10


def test_the_particle_filter_nears_the_exact_one_by_the_root_of_its_particles(compare: Compare) -> None:
    means = [(particles, compare("particle", particles, 40)["mean"]) for particles in (100, 1000, 10000)]
    assert filter_program.slope(means) == pytest.approx(-0.5, abs=0.05)


@pytest.mark.parametrize("kind", ["exact", "factored", "particle"])
def test_the_truth_has_every_rank_equally_often(compare: Compare, kind: str) -> None:
    ranks = compare(kind, 1000, 1000)["ranks"]
    assert sum(ranks) > 800
    assert filter_program.chi_square(ranks) < CHI_SQUARE_9


@pytest.mark.parametrize("steps", [0, 5])
def test_the_first_belief_is_conditioned_on_what_is_seen_first(compare_start: Compare, steps: int) -> None:
    # A ninth is no whole number of random words.
    assert compare_start("limit", 1, 100, steps)["largest"] < 1e-8
    assert compare_start("factored", 1, 300, steps)["largest"] < 1e-8


def test_first_particles_near_the_exact_belief_by_the_root_of_their_number(compare_start: Compare) -> None:
    means = [(n, compare_start("particle", n, 100)["mean"]) for n in (100, 1000, 10000)]
    assert filter_program.slope(means) == pytest.approx(-0.5, abs=0.05)


@pytest.mark.parametrize("kind", ["exact", "factored", "particle"])
@pytest.mark.parametrize("steps", [0, 5])
def test_the_truth_has_every_rank_after_a_first_look(compare_start: Compare, kind: str, steps: int) -> None:
    assert filter_program.chi_square(compare_start(kind, 1000, 1000, steps)["ranks"]) < CHI_SQUARE_9


def test_cells_that_the_first_look_has_not_read_are_drawn_anew(compare_map: Compare) -> None:
    for steps in (0, 4):
        assert compare_map("limit", 1, 50, steps)["largest"] < 1e-8
        assert filter_program.chi_square(compare_map("particle", 300, 1000, steps)["ranks"]) < CHI_SQUARE_9
    means = [(n, compare_map("particle", n, 100)["mean"]) for n in (100, 1000, 10000)]
    assert filter_program.slope(means) == pytest.approx(-0.5, abs=0.05)


@pytest.mark.parametrize("kind", ["factored", "particle"])
def test_elements_that_are_tied_have_particles_beside_an_independent_one(
    compare_pair: Compare, kind: str
) -> None:
    assert filter_program.chi_square(compare_pair(kind, 300, 1000, 5)["ranks"]) < CHI_SQUARE_9
    means = [(n, compare_pair(kind, n, 100, 5)["mean"]) for n in (100, 1000, 10000)]
    assert filter_program.slope(means) == pytest.approx(-0.5, abs=0.05)
