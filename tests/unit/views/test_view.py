# SPDX-License-Identifier: Apache-2.0
import json
import math
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from support import seen_episodes

from hypgen.dsl.load import load
from hypgen.views import entries_of, page_of
from hypgen.views import view as view_module
from hypgen.views.texts import number

EXAMPLES = Path(__file__).parents[3] / "examples"


def view(count: int = 4, nodes: int = 60) -> dict[str, Any]:
    steps = seen_episodes.steps(count, nodes)
    return seen_episodes.view(steps, seen_episodes.end(), scene=seen_episodes.scene())


def test_what_is_earned_from_a_step_on_is_the_discounted_sum_of_rewards() -> None:
    rewards = [0.0, -0.25, -0.5, -0.75]
    wanted = [sum(r * seen_episodes.DISCOUNT**i for i, r in enumerate(rewards[k:])) for k in range(4)]
    assert [one["earned"] for one in view()["steps"]] == pytest.approx(wanted)


def test_nothing_is_earned_where_a_reward_is_unknown() -> None:
    steps = seen_episodes.steps(3)
    steps[1]["reward"] = None
    assert [one["earned"] is None for one in seen_episodes.view(steps)["steps"]] == [
        True,
        True,
        False,
    ]


def test_marginals_stand_beside_the_truth() -> None:
    names = {"rock.good": ["rock.good[0]", "rock.good[1]"]}
    shown = seen_episodes.view(seen_episodes.steps(1), entries=names)["steps"][0]
    truths = {one["variable"]: one.get("true") for one in shown["marginals"]}
    assert truths == {"robot.x": 0, "rock.good[0]": True, "robot.angle": None}


def test_a_belief_is_measured_by_what_is_true() -> None:
    names = {"rock.good": ["rock.good[0]", "rock.good[1]"]}
    shown = seen_episodes.view(seen_episodes.steps(2), entries=names)["steps"]
    assert shown[0]["believed"] == {"mean": (0.75 + 0.125) / 2, "least": 0.125, "variable": "rock.good[0]"}
    assert seen_episodes.view([{"step": 0, "action": "go(0)"}])["steps"][0]["believed"] is None


def test_entries_have_the_names_that_solvers_print() -> None:
    names = entries_of(load(EXAMPLES / "navigation.pomdp").model)
    assert names["terrain.occ"][14] == "terrain.occ[1, 1]"
    assert entries_of(load(EXAMPLES / "rock_sample.pomdp").model)["rock.good"][3] == "rock.good[3]"


def test_trees_share_the_room_of_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(view_module, "ALL_NODES", 100)
    found = view(count=5)
    assert {(one["tree_shown"], one["tree_total"]) for one in found["steps"]} == {(20, 60)}
    assert "Trees are cut to their most visited nodes, 20 at most." in found["notes"]


def test_what_a_recording_left_out_of_a_tree_is_counted() -> None:
    steps = [one | {"tree_total": 9000} for one in seen_episodes.steps(1)]
    found = seen_episodes.view(steps)
    assert (found["steps"][0]["tree_shown"], found["steps"][0]["tree_total"]) == (60, 9000)


def test_marginals_keep_their_likeliest_values() -> None:
    values = [{"value": str(n), "probability": n / 28} for n in range(8)]
    marginals = [{"variable": f"x[{n}]", "values": values} for n in range(401)]
    step = seen_episodes.steps(1)[0] | {"marginals": marginals, "state": {"x[0]": 1}}
    found = seen_episodes.view([step])["steps"][0]
    assert len(found["marginals"]) == 400 and found["marginals_left_out"] == 1
    assert [one["value"] for one in found["marginals"][0]["values"]] == ["7", "6", "5", "4", "3"]
    assert found["marginals"][0]["values_left_out"] == 3
    assert found["believed"]["least"] == pytest.approx(1 / 28), "an improbable truth is not impossible"


def test_a_page_says_what_is_missing() -> None:
    steps = [one | {"tree": None} for one in seen_episodes.steps(2)]
    notes = seen_episodes.view(
        steps, header=seen_episodes.header() | {"ended": "step_limit"}, notes=["A line was cut off."]
    )["notes"]
    assert notes[0] == "A line was cut off."
    for start in ("The episode was cut off by its step limit", "No step has", "The model has no draw"):
        assert any(note.startswith(start) for note in notes), start


class Page(HTMLParser):
    """What a browser would find in a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.scripts: list[str] = []
        self.addresses: list[str] = []
        self._in_script = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [str(value) for name, value in attrs if name in ("src", "href")]
        if tag == "script":
            self.scripts.append("")
        self._in_script = tag == "script"

    def handle_data(self, data: str) -> None:
        if self._in_script:
            self.scripts[-1] += data

    def handle_endtag(self, tag: str) -> None:
        self._in_script = False


def test_a_page_has_its_data_inside_whatever_names_say() -> None:
    found = view()
    page = Page(page_of(found))
    assert len(page.scripts) == 2 and page.addresses == []
    assert json.loads(page.scripts[0]) == found


def test_numbers_that_json_lacks_are_unknown() -> None:
    found = view(1)
    found["steps"][0]["lower"], found["steps"][0]["upper"] = -math.inf, math.nan
    step = json.loads(Page(page_of(found)).scripts[0])["steps"][0]
    assert step["lower"] is None and step["upper"] is None


def test_the_same_episode_gives_the_same_page() -> None:
    assert page_of(view()) == page_of(view())


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (2.0, "2"),
        (-0.25, "-0.25"),
        (12345.6, "12346"),
        (0.00001, "1e-05"),
        (None, "unknown"),
        (math.nan, "unknown"),
    ],
)
def test_numbers_have_four_digits(value: float | None, text: str) -> None:
    assert number(value) == text
