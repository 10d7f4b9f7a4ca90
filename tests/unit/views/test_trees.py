# SPDX-License-Identifier: Apache-2.0
from collections.abc import Iterator
from typing import Any

import pytest
from support import seen_episodes

from hypgen.views import trees


def nodes(tree: dict[str, Any]) -> Iterator[dict[str, Any]]:
    yield tree
    for child in (*tree.get("actions", ()), *tree.get("groups", ())):
        yield from nodes(child)


@pytest.mark.parametrize("most", [1, 2, 7, 59, 60, 100])
def test_the_most_visited_nodes_stay_and_the_rest_is_counted(most: int) -> None:
    whole = seen_episodes.tree(60)
    cut = trees.cut(whole, most)
    kept = list(nodes(cut))
    assert trees.size(cut) == len(kept) == min(most, 60)
    least = min(one["visits"] for one in kept)
    assert sum(one["visits"] > least for one in nodes(whole)) == len(kept) - 1
    gone = [one.get("actions_left_out", 0) + one.get("groups_left_out", 0) for one in kept]
    cut_off = (
        sum(len(one.get("actions", ())) + len(one.get("groups", ())) for one in nodes(whole)) - len(kept) + 1
    )
    assert sum(gone) <= cut_off  # nodes below what is gone are not counted
    assert (sum(gone) > 0) == (most < 60)


def test_a_tree_that_is_small_enough_stays_as_it_is() -> None:
    whole = seen_episodes.tree(60)
    assert trees.cut(whole, 60) == whole


def test_what_was_left_out_before_is_counted_too() -> None:
    whole = {"visits": 9, "actions_left_out": 4, "actions": [{"visits": 5}, {"visits": 4}]}
    assert trees.cut(whole, 2) == {"visits": 9, "actions_left_out": 5, "actions": [{"visits": 5}]}


def test_the_root_keeps_all_actions() -> None:
    below = [{"visits": 9, "actions": [{"visits": 9}]}]
    whole = {"visits": 9, "actions": [{"visits": 9, "groups": below}, {"visits": 0}]}
    assert trees.cut(whole, 3) == {
        "visits": 9,
        "actions": [{"visits": 9, "groups": [], "groups_left_out": 1}, {"visits": 0}],
    }
