# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from hypgen.experiments.statistics import compare, holm, mean_of


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
