# SPDX-License-Identifier: Apache-2.0
import math
import tracemalloc

import numpy as np
import pytest

from hypgen.experiments.statistics import compare, difference_of, holm, mean_of, share_of


def test_the_interval_of_many_normal_values_is_the_usual_one() -> None:
    values = np.random.default_rng(1).normal(3.0, 2.0, 400)
    found = mean_of(values)
    assert found.mean == pytest.approx(values.mean())
    half = 1.96 * values.std(ddof=1) / 20
    assert found.high - found.mean == pytest.approx(half, rel=0.1)
    assert found.mean - found.low == pytest.approx(half, rel=0.1)


def test_few_or_equal_values_have_what_is_known_of_them() -> None:
    assert str(mean_of([])) == ""
    assert str(mean_of([1.0, 2.0])) == "1.500"
    assert str(mean_of([2.0] * 5)) == "2.000 (2.000 .. 2.000)"
    assert str(mean_of([0.3, 0.1 + 0.2, 0.3])) == "0.300 (0.300 .. 0.300)"


def test_rounding_does_not_make_equal_values_differ() -> None:
    found = mean_of([0.1 + 0.2, 0.3, 0.3, 0.30000000000000004])
    assert found.low == found.mean == found.high


def test_many_values_take_little_memory() -> None:
    values = np.random.default_rng(4).normal(1.0, 1.0, 20_000)
    tracemalloc.start()
    [found] = compare([(dict(enumerate(values[:3000])), dict.fromkeys(range(3000), 0.0))])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.is_shown and peak < 200e6, "all resamples at once would be 480 MB"


def test_a_share_stays_within_0_and_1_and_knows_that_few_say_little() -> None:
    assert share_of([]).count == 0
    all_of_ten = share_of([True] * 10)
    assert (all_of_ten.mean, all_of_ten.high) == (1.0, 1.0) and 0.65 < all_of_ten.low < 0.75
    half = share_of([True, False] * 50)
    assert half.mean == 0.5 and half.high - half.low == pytest.approx(0.19, abs=0.01)


def test_a_difference_is_paired() -> None:
    noise = dict(enumerate(np.random.default_rng(5).normal(0.0, 9.0, 30)))
    found = difference_of({i: value + 1.0 for i, value in noise.items()} | {99: 5.0}, noise)
    assert found.count == 30 and found.low == pytest.approx(1.0) and found.high == pytest.approx(1.0)


def test_holm_multiplies_by_the_comparisons_that_are_left() -> None:
    assert holm([0.01, 0.04, 0.03, math.nan]) == pytest.approx([0.03, 0.06, 0.06, math.nan], nan_ok=True)
    assert holm([0.9, 0.8]) == [1.0, 1.0]


def test_differences_are_of_common_episodes_and_chance_shows_nothing() -> None:
    random = np.random.default_rng(2)
    theirs = dict(enumerate(random.normal(0.0, 5.0, 60)))
    better = {i: value + random.normal(1.0, 1.0) for i, value in theirs.items()}
    same = {i: value + random.normal(0.0, 1.0) for i, value in theirs.items() if i < 50}
    shown, hidden = compare([(better, theirs), (same, theirs)])
    assert shown.is_shown and shown.interval.count == 60
    assert not hidden.is_shown and hidden.interval.count == 50 and str(hidden).endswith(", not shown")


def test_chance_alone_is_rarely_shown() -> None:
    random = np.random.default_rng(3)
    found = 0
    for _ in range(100):
        theirs = dict(enumerate(random.normal(0.0, 1.0, 20)))
        [difference] = compare(
            [({i: value + random.normal(0.0, 1.0) for i, value in theirs.items()}, theirs)]
        )
        found += difference.is_shown
    assert found <= 11  # of 5 expected: P(more) is 0.4 %
