# SPDX-License-Identifier: Apache-2.0
"""Ranks of beliefs that are right, too sure, too wide or biased."""

import math
import random
from collections.abc import Callable

import pytest

from hypgen.play.rank_statistics import Ranks, chi_square_tail, corrected


def drawn(draw: Callable[[random.Random], float], number: int = 500) -> Ranks:
    generator = random.Random(3)
    return Ranks([draw(generator) for _ in range(number)])


RIGHT = drawn(lambda r: r.random())


def test_uniform_ranks_are_level() -> None:
    assert RIGHT.p() > 0.05
    assert len(RIGHT.histogram()) == 20 and sum(RIGHT.histogram()) == 500
    held, low, high = RIGHT.coverage(0.5)
    assert low < 0.5 < high and low < held < high and high - low == pytest.approx(0.087, abs=0.002)
    assert RIGHT.coverage(0.95)[0] == pytest.approx(0.95, abs=0.03)


@pytest.mark.parametrize(
    "draw, shape",
    [
        (lambda r: r.betavariate(0.5, 0.5), "sure"),
        (lambda r: r.betavariate(3, 3), "wide"),
        (lambda r: r.betavariate(2, 1), "low"),
        (lambda r: r.betavariate(1, 2), "high"),
        (lambda r: r.randrange(10) / 10 + 0.05, "uneven"),
    ],
)
def test_ranks_that_are_not_level_have_a_shape(draw: Callable[[random.Random], float], shape: str) -> None:
    found = drawn(draw)
    assert found.p() < 1e-6
    assert found.shape() == shape


def test_a_right_belief_is_seldom_rejected() -> None:
    generator = random.Random(1)
    p = [Ranks([generator.random() for _ in range(50)]).p() for _ in range(2000)]
    assert sum(x < 0.05 for x in p) / 2000 == pytest.approx(0.05, abs=0.015)
    assert sum(x < 0.001 for x in p) < 10


def test_few_ranks_have_few_bins() -> None:
    assert len(Ranks([0.5] * 50).histogram()) == 10
    assert Ranks([0.0, 1.0, 0.5]).histogram() == [3]
    assert Ranks([0.5] * 3).p() == 1.0
    empty = Ranks([])
    assert empty.p() == 1.0 and math.isnan(empty.coverage(0.5)[0]) and empty.shape() == "uneven"


def test_blocks_show_the_histogram() -> None:
    assert Ranks([0.1] * 10 + [0.7] * 10).blocks() == "█▁█▁"
    assert Ranks([i / 100 + 0.001 for i in range(100)]).blocks() == "▅" * 20


@pytest.mark.parametrize(
    "x, degrees, p", [(3.841459, 1, 0.05), (5.991465, 2, 0.05), (27.877, 9, 0.001), (30.14353, 19, 0.05)]
)
def test_the_tail_of_chi_square_is_that_of_tables(x: float, degrees: int, p: float) -> None:
    assert chi_square_tail(x, degrees) == pytest.approx(p, rel=1e-4)
    assert chi_square_tail(0.0, degrees) == 1.0
    assert chi_square_tail(5000.0, degrees) == 0.0


def test_p_values_are_corrected_for_their_number() -> None:
    assert corrected([0.01, 0.02, 0.5]) == pytest.approx([0.03, 0.04, 0.5])
    assert corrected([0.04, 0.03, 0.02]) == pytest.approx([0.06, 0.06, 0.06])
    assert corrected([0.9, 0.8]) == [1.0, 1.0]
    assert corrected([]) == []
