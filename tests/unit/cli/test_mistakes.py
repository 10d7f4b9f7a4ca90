# SPDX-License-Identifier: Apache-2.0
"""Newcomers' mistakes, which the corpus of wrong models has: docs/results/mistakes.md shows them."""

import mistakes


def test_there_are_many_and_many_are_stans() -> None:
    found = mistakes.mistakes()
    assert len({m.what for m in found}) == len(found) >= 60
    assert sum(m.stan_text is not None for m in found) >= 25


def test_the_page_is_up_to_date() -> None:
    assert mistakes.PAGE.read_text() == mistakes.page(), "run python benchmarks/mistakes.py"
