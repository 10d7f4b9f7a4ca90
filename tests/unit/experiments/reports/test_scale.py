# SPDX-License-Identifier: Apache-2.0
import math

import pytest

from hypgen.experiments.reports.scale import scale_of, tick_label
from hypgen.experiments.reports.texts import (
    count_text,
    interval_text,
    mean_text,
    percent,
    seconds_text,
    signed,
)
from hypgen.experiments.statistics import Interval


def test_an_axis_shows_all_values_between_round_numbers() -> None:
    scale = scale_of([3.1, 17.9, math.nan], 0.0, 100.0)
    assert scale.low < 3.1 and scale.high > 17.9
    assert scale.ticks(5) == [5.0, 10.0, 15.0]
    assert 0.0 < scale(3.1) < scale(17.9) < 100.0
    assert (scale(-1e9), scale(1e9)) == (0.0, 100.0)


def test_a_logarithmic_axis_has_equal_decades() -> None:
    scale = scale_of([0.01, 0.1, 1.0, 0.0, -1.0], 0.0, 100.0, is_log=True)
    assert scale(0.1) - scale(0.01) == pytest.approx(scale(1.0) - scale(0.1))
    assert scale.ticks(6) == pytest.approx([0.01, 0.03, 0.1, 0.3, 1.0])
    assert scale_of([1.0, 1e9], 0, 1, is_log=True).ticks(4) == pytest.approx([1.0, 1e3, 1e6, 1e9])


@pytest.mark.parametrize("values", [[], [5.0], [0.0, 0.0], [-3.0]])
def test_an_axis_of_one_value_or_none_has_a_length(values: list[float]) -> None:
    scale = scale_of(values, 0.0, 1.0)
    assert scale.high > scale.low and scale.ticks()


def test_numbers_are_short() -> None:
    values = (0.0, 0.03, 5.0, -7.5, 1000.0, 2e6, 1e-4)
    assert [tick_label(v) for v in values] == [
        "0",
        "0.03",
        "5",
        "\u22127.5",
        "1,000",
        "2\u00d710\u2076",
        "10\u207b\u2074",
    ]
    assert mean_text(Interval(12.3456, 11.9, 12.9, 9)) == "12.35"
    assert interval_text(Interval(-12.3456, -20.0, -5.0, 9)) == "\u221220.0 to \u22125.0"
    assert interval_text(Interval(1.0, math.nan, math.nan, 2)) == ""
    assert mean_text(Interval(math.nan, math.nan, math.nan, 0)) == ""
    assert (signed(Interval(1.5, 1.0, 2.0, 9)), signed(Interval(0.0, 0.0, 0.0, 9))) == ("+1.50", "0.00")
    assert [seconds_text(v) for v in (2.0, 0.03, 1e-5, math.nan)] == ["2 s", "30 ms", "10 \u00b5s", ""]
    assert [count_text(v) for v in (0.123, 14.7, 48123.4, math.nan)] == ["0.123", "14.7", "48,123", ""]
    assert [percent(v) for v in (0.0, 0.125, 1.0, math.nan)] == ["0 %", "12.5 %", "100 %", ""]
