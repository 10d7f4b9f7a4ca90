# SPDX-License-Identifier: Apache-2.0
from typing import Any

import pytest

from hypgen.views.why import why

BEST = {"name": "listen", "visits": 9, "lower": 2.5, "upper": 4.0}
OTHER = {"name": "open", "visits": 3, "lower": 1.0, "upper": 3.0}


def step(*actions: dict[str, Any], default: str | None = "open", **more: Any) -> dict[str, Any]:
    return {"action": "listen", "default_action": default, "tree": {"actions": list(actions)}} | more


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            step(BEST, OTHER),
            "listen has the largest lower bound: 2.5, which is 1.5 more than that of the second, open.",
        ),
        (
            step(BEST, OTHER),
            "The bounds do not decide: open may be worth up to 3, 0.5 above the lower bound of listen.",
        ),
        (
            step(BEST, OTHER | {"upper": 2.5}),
            "The bounds decide: no other action here has an upper bound above that.",
        ),
        (step(BEST, OTHER), "The default policy would do open: the lower bound promises 1.5 more."),
        (step(BEST, OTHER, default="listen"), "The default policy would do the same."),
        (step(BEST, OTHER, default="wait"), "would do wait, which is not among the actions compared here."),
        (step(BEST, OTHER | {"lower": 2.5}, default="listen"), "Ties go to the default policy's action."),
        (
            step(BEST, OTHER | {"lower": 3.0}),
            "listen was taken, though the lower bound of open is 0.5 larger",
        ),
        (
            step(BEST | {"mean": 7.0}, OTHER | {"mean": 6.0}),
            "listen has the largest mean return: 7, which is 1 more",
        ),
        (step(BEST | {"mean": 7.0}, OTHER | {"mean": 6.0}), "do open: the mean return promises 1 more."),
        (step(BEST, OTHER | {"lower": None}), "The lower bound of listen is not known."),
        (step(BEST), "listen is the only action that was compared."),
        (step(OTHER), "There is no tree that says why listen was taken."),
        (step(lower=1.0), "listen came first among actions before the default policy."),
        (
            step(default="listen", status="deadline"),
            "listen is what the default policy does. No tree was searched.",
        ),
        (
            step(looked="one_step"),
            "listen came first among actions before the default policy. No tree decided.",
        ),
    ],
)
def test_the_sentence_is_made_of_the_numbers(given: dict[str, Any], said: str) -> None:
    assert said in why(given)


def test_it_says_how_many_actions_are_not_compared() -> None:
    given = step(BEST, OTHER)
    given["tree"]["actions_left_out"] = 2
    assert why(given).endswith("2 actions that fewer trials took are not compared here.")


def compared(name: str, gain: float, error: float = 0.5) -> dict[str, Any]:
    return {"name": name, "gain": gain, "standard_error": error, "samples": 100}


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (
            [compared("open", 0.0), compared("listen", 1.5), compared("wait", -0.25)],
            "In paired rollouts it earned 1.5 more (3 standard errors) than open. "
            "wait earned 0.25 less (0.5 standard errors) than open.",
        ),
        ([compared("wait", 0.25, 0.0)], "wait earned 0.25 more than open."),
        ([compared("open", 0.0)], ""),
        (None, ""),
    ],
)
@pytest.mark.parametrize("tree", [{"tree": None}, {}])
def test_gains_are_in_units_of_the_paired_error(
    found: list[dict[str, Any]] | None, said: str, tree: dict[str, Any]
) -> None:
    text = why(step(BEST, OTHER, compared=found) | tree)
    assert text.endswith(said) and (said != "" or "earned" not in text)
