# SPDX-License-Identifier: Apache-2.0
"""A made-up episode as a page takes it: a robot on a grid, trees of any size, hostile names."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from hypgen.views import most_nodes, shown_step, view_of

HOSTILE = "</script><script>document.title='taken'</script><!-- & \"quoted\""
DISCOUNT = 0.95
_FRUITFUL = 5  # children of a node, as far as the tree reaches


def header() -> dict[str, Any]:
    """Return what is known of the whole episode."""
    return {
        "name": f"Grid {HOSTILE}",
        "hash": "0123",
        "file": "grid.pomdp",
        "discount": DISCOUNT,
        "options": {"mode": "despot", "time": 0.1},
        "episode": 3,
        "ended": "terminal",
    }


def view(
    of: Sequence[Mapping[str, Any]],
    *more: Any,
    entries: Mapping[str, Sequence[str]] | None = None,
    **said: Any,
) -> dict[str, Any]:
    """Return what a page shows of steps; further arguments are those of ``view_of``, from its end on."""
    given = said.pop("header", header())
    return view_of(given, [shown_step(one, most_nodes(len(of)), entries) for one in of], *more, **said)


def steps(count: int, nodes: int = 60) -> list[dict[str, Any]]:
    """Return so many steps, each with a tree of so many nodes."""
    return [step(number, nodes) for number in range(count)]


def step(number: int, nodes: int) -> dict[str, Any]:
    """Return a step: the robot goes along the grid's rows."""
    x, y = number % 5, number // 5 % 5
    return {
        "step": number,
        "action": "go(0)",
        "default_action": f"go({number % 3})",
        "reward": -0.25 * number,
        "terms": {"way": -1.0 * number, HOSTILE: 0.75 * number},
        "seen": {HOSTILE: "wet", "walls": [True, False]},
        "state": {"robot.x": x, "robot.y": y, "rock.good": [True, False], "time": number},
        "marginals": [
            {
                "variable": "robot.x",
                "values": [{"value": str(x), "probability": 0.75}, {"value": HOSTILE, "probability": 0.25}],
            },
            {"variable": "rock.good[0]", "values": [{"value": "true", "probability": 0.125}]},
            {"variable": "robot.angle", "mean": 0.5, "deviation": 0.0625},
        ],
        "truth": [marker(x, y)],
        "belief": [
            marker(x, y) | {"p": 0.75},
            marker(4 - x, y) | {"p": 0.25},
            gauge(number % 4) | {"p": 1.0},
        ],
        "belief_shown": 3,
        "belief_total": 7,
        "status": "deadline",
        "lower": 1.0 - number,
        "upper": 3.5,
        "search_seconds": 0.0125 * (number + 1),
        "update_seconds": 0.002,
        "nodes": 1000 + number,
        "effective_sample_size": 4000.25 - number,
        "tree": tree(nodes),
    }


def marker(x: int, y: int) -> dict[str, Any]:
    """Return where the robot is."""
    return {"shape": "marker", "name": f"robot {HOSTILE}", "x": x, "y": y, "colour": "blue", "heading": 0.5}


def gauge(value: int) -> dict[str, Any]:
    """Return how full it is."""
    return {"shape": "gauge", "name": "fuel", "value": value, "low": 0, "high": 4, "colour": "orange"}


def scene() -> dict[str, Any]:
    """Return what does not move."""
    goal = {"shape": "cell", "name": "goal", "x": 4, "y": 4, "colour": "green", "text": HOSTILE}
    return {"extent": {"x": [0, 4], "y": [0, 4], "cells": True}, "static": [goal]}


def end() -> dict[str, Any]:
    """Return what is true after the last step."""
    return {"state": {"robot.x": 4}, "truth": [marker(4, 4)], "belief": []}


def tree(nodes: int) -> dict[str, Any]:
    """Return a tree of so many nodes, level by level; earlier children have more visits."""
    root: dict[str, Any] = {"scenarios": 500, "share": 1.0, "visits": nodes, "lower": 1.5, "upper": 3.5}
    numbers = itertools.count(1)
    level = [(root, "actions")]
    for parent, kind in level:
        for place in range(_FRUITFUL):
            number = next(numbers)
            if number >= nodes:
                return root
            child = {"visits": nodes - number, "lower": 1.5 - place, "upper": 3.5 - 0.125 * place}
            if kind == "actions":
                child |= {"action": place, "name": f"go({place})" if place < 4 else HOSTILE}
            else:
                child |= {"share": 0.2, "scenarios": 100, "seen": {"reading": f"value {place}"}}
            parent.setdefault(kind, []).append(child)
            level.append((child, "groups" if kind == "actions" else "actions"))
    raise AssertionError("the list of levels grows while it is read")
