# SPDX-License-Identifier: Apache-2.0
import math

import pytest

from hypgen.play import paired_statistics


def test_an_interval_is_1_96_standard_errors() -> None:
    assert paired_statistics.interval([1.0, 2.0, 3.0, 4.0]) == pytest.approx(
        (2.5, 1.96 * math.sqrt(5 / 3) / 2)
    )
    assert paired_statistics.interval([7.0])[0] == 7.0 and math.isnan(paired_statistics.interval([7.0])[1])
    assert all(map(math.isnan, paired_statistics.interval([])))


def test_differences_are_those_of_common_episodes() -> None:
    assert paired_statistics.differences({3: 5.0, 1: 2.0, 7: 0.0}, {1: 1.0, 2: 9.0, 3: 1.0}) == [1.0, 4.0]
    assert paired_statistics.with_interval([1.0, 4.0], "+") == "+2.500 +- 2.940"
