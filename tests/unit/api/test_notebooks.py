# SPDX-License-Identifier: Apache-2.0
"""What notebooks show of a model and of a decision."""

from pathlib import Path

import hypgen
from hypgen.api.html import table

TIGER = Path(__file__).parents[3] / "examples" / "tiger.pomdp"


def test_a_model_shows_its_parts() -> None:
    shown = hypgen.load(TIGER)._repr_html_()
    assert shown.startswith("<table><caption>model Tiger</caption>")
    for text in ("act: Act, 3 in all", "room.tiger: Door", "heard: Door", "0.95"):
        assert text in shown


def test_a_decision_shows_action_bounds_and_work() -> None:
    decision = hypgen.Decision(2, "open(left & right)", "deadline", -1.5, 19.25, 0.05, 7, 40, 500, 12)
    shown = decision._repr_html_()
    assert "open(left &amp; right) (number 2)" in shown
    assert "-1.5 .. 19.25" in shown and "deadline" in shown


def test_texts_are_escaped() -> None:
    assert "<b>" not in table("<b>", [("<b>", "<b>")])
