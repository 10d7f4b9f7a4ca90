# SPDX-License-Identifier: Apache-2.0
"""Beliefs about floats by mean and deviation, beside the posterior on a fine grid and beside exact ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.grid_filter import GridFilter, distances
from support.paths import ROOT

from hypgen.dsl import ir
from hypgen.dsl.interpret.episode import Episode
from hypgen.dsl.interpret.evaluate.moments import POINTS, Law, Points, Sums, Update
from hypgen.dsl.load import load
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

FOLDER = ROOT / "benchmarks" / "beliefs" / "floats"

# Of the grid's deviations: how far means are apart on average and at most; the ends of the deviations' ratio.
NEAR = {
    "cart": ("cart", -8.0, 8.0, 0.002, 0.01, (0.99, 1.01)),
    "coin": ("coin", 0.0, 1.0, 0.01, 0.03, (0.98, 1.02)),
    "sonar": ("wreck", 0.0, 20.0, 0.1, 0.5, (0.75, 1.2)),
    "tank": ("tank", -4.0, 16.0, 0.15, 0.8, (0.7, 1.5)),
}


@pytest.mark.parametrize("name", NEAR)
def test_what_is_kept_is_near_the_posterior_on_a_grid(name: str) -> None:
    element, low, high, average, most, ends = NEAR[name]
    model = load(FOLDER / f"{name}.pomdp").model
    apart, ratio = distances(model, GridFilter(model, element, low, high, 300), 3, 10, 1).T
    assert len(apart) > 20
    assert np.abs(apart).mean() < average
    assert np.abs(apart).max() < most
    assert ends[0] < ratio.min() and ratio.max() < ends[1]


def test_a_linear_motion_with_normal_noise_is_exact() -> None:
    mean, variance = known(
        """
        element cart {
          hidden x: float
          init x ~ normal(3.0, 2.0)
          x' ~ normal(0.9 * x + 1, 0.5)
        }
        policy default = if belief(cart.x) > 0 then 1 else 2
        """,
        5,
    )
    exact_mean, exact_variance = 3.0, 4.0
    for _ in range(5):
        exact_mean, exact_variance = 0.9 * exact_mean + 1, 0.81 * exact_variance + 0.25
    assert mean == pytest.approx(exact_mean, rel=1e-6)
    assert variance == pytest.approx(exact_variance, rel=1e-5)


def test_what_nothing_moves_or_tells_of_stays_bit_for_bit() -> None:
    mean, variance = known(
        """
        element thing {
          hidden x: float
          init x ~ exponential(3.0)
          x' ~ if act == 3 then normal(x, 1.0) else x
        }
        observe seen: bool ~ if act == 3 then noisy(thing.x' > 1, 0.9) else bernoulli(0.3)
        policy default = if belief(thing.x) > 0 then 1 else 2
        """,
        4,
    )
    assert (mean, variance) == (3.0, 9.0)


def test_a_table_has_the_moments_of_its_entries() -> None:
    mean, variance = known(
        """
        element thing { hidden fixed x: float  init x ~ { 1.0: 0.25, 2.0: 0.5, else 5.0 } }
        policy default = if belief(thing.x) > 0 then 1 else 2
        """,
        1,
    )
    assert (mean, variance) == (2.5, pytest.approx(2.25, rel=1e-6))


def test_deviation_of_a_finite_variable_is_that_of_its_posterior() -> None:
    model = model_of(
        """
        element die { hidden fixed n: 1 .. 6  init n ~ uniform(1, 6) }
        policy default =
          if deviation(die.n) > 1.7 and deviation(die.n) < 1.71 and belief(die.n) == 3.5 then 2 else 1
        """
    )
    assert Episode(model).policy_action() == 1  # the code of 2


@pytest.mark.parametrize("ranged", [False, True])
def test_the_points_give_back_the_moments_of_their_law(ranged: bool) -> None:
    ends = (np.asarray(0.0), np.asarray(10.0)) if ranged else None
    law = Law(np.array([[4.0, 0.75]], dtype=np.float32), ends)
    points, sums = Points(law, law.mean, law.deviation), Sums(1)
    for k in range(POINTS):
        sums.add(law.density(points.at(k)), points.at(k).astype(np.float64))
    assert sums.mean()[0] == pytest.approx(4.0, abs=1e-6)
    assert sums.deviation()[0] == pytest.approx(0.75, rel=1e-6)


def test_a_uniform_law_is_the_beta_law_of_its_moments() -> None:
    law = Law(np.array([[5.0, 10 / math.sqrt(12)]], dtype=np.float32), (np.asarray(0.0), np.asarray(10.0)))
    densities = [law.density(np.array([x], dtype=np.float32))[0] for x in (0.1, 2.0, 5.0, 9.9)]
    assert densities == pytest.approx([1.0] * 4, abs=1e-5)
    assert law.density(np.array([10.0], dtype=np.float32))[0] == 0


def test_a_posterior_much_narrower_than_the_points_distance_is_found() -> None:
    """A sensor whose noise is a twentieth of the deviation before."""
    update = Update(Law(np.array([[0.0, 100.0]], dtype=np.float32), None))
    while update.due():
        x = update.points()
        update.sweep(x, np.exp(-0.5 * ((x.astype(np.float64) - 37.21) / 5.0) ** 2))
    mean, deviation = update.kept()[0]
    assert mean == pytest.approx(37.21 / (1 + 0.05**2), abs=0.01)
    assert deviation == pytest.approx(5 / math.sqrt(1 + 0.05**2), abs=0.01)


def test_what_no_point_explains_leaves_the_belief_as_it_is() -> None:
    update = Update(Law(np.array([[2.0, 3.0]], dtype=np.float32), None))
    update.sweep(update.points(), np.zeros((1, POINTS)))
    assert not update.due()
    assert update.kept()[0].tolist() == [2.0, 3.0]


def test_a_simulation_tells_what_the_policy_knows() -> None:
    episode = Episode(load(FOLDER / "coin.pomdp").model)
    ((mean, deviation),) = episode.moments()["coin"]
    assert (mean, deviation) == (0.5, pytest.approx(1 / math.sqrt(12)))
    episode.step(0)
    ((mean, _),) = episode.moments()["coin"]
    assert min(abs(mean - 1 / 3), abs(mean - 2 / 3)) < 0.002


def known(text: str, steps: int) -> tuple[float, float]:
    """Return mean and variance of the one float after some steps of the default policy."""
    episode = Episode(model_of(text))
    for _ in range(steps):
        episode.step(episode.policy_action())
    (((mean, deviation),),) = episode.moments().values()
    return mean, deviation**2


def model_of(text: str) -> ir.Model:
    """Return a model with some elements and a policy."""
    head = "model Floats\ndiscount 0.9\naction act: 1 .. 3\nreward none = 0\n"
    source = Source("m.pomdp", head + text)
    return lower(parse(source), {}, source)
