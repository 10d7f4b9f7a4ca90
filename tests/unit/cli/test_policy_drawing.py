# SPDX-License-Identifier: Apache-2.0
"""Drawings of a policy's graph: what they show, and what is refused before anything is solved."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from hypgen.cli.commands.solve import command
from hypgen.cli.exit_codes import Exit
from hypgen.cli.show import policy_drawing

TIGER = str(Path(__file__).parent.parent.parent.parent / "examples" / "tiger.pomdp")


def edge(to: int | None, probability: float, *observations: str) -> dict[str, Any]:
    return {
        "to": to,
        "probability": probability,
        "observations": list(observations),
        "observations_left_out": 0,
    }


GRAPH: dict[str, Any] = {
    "starts": [{"probability": 1.0, "seen": None, "to": 1}],
    "starts_left_out": 0,
    "nodes": [
        {"node": 1, "action": "listen", "value": 19.4, "ends": 0.0, "edges_left_out": 0}
        | {"edges": [edge(2, 0.6, "left"), edge(1, 0.3, "right"), edge(None, 0.1, "a", "b", "$c$")]},
        {"node": 2, "action": "open_<right>", "value": 28.7, "ends": 0.25, "edges_left_out": 0}
        | {"edges": [edge(1, 0.75, "left")]},
    ],
    "nodes_left_out": 7,
    "may_have_more": True,
}


def texts(drawing: bytes) -> list[str]:
    return [(e.text or "") for e in ElementTree.fromstring(drawing).iter() if e.tag.endswith("}text")]


def test_a_drawing_names_actions_and_observations() -> None:
    pytest.importorskip("networkx")
    pytest.importorskip("matplotlib")
    drawing = policy_drawing.draw(GRAPH, "Tiger", ".svg")
    shown = "\n".join(texts(drawing))
    for text in (
        "Tiger",
        "start",
        "1 listen",
        "2 open_<right>",
        "0.6",
        "left",
        "7 or more",
        "the end",
        "0.25",
    ):
        assert text in shown
    assert "and 1 more" in shown
    assert drawing == policy_drawing.draw(GRAPH, "Tiger", ".svg")
    assert policy_drawing.draw(GRAPH, "Tiger", ".png").startswith(b"\x89PNG")


def refusal(*options: str) -> str:
    done = CliRunner().invoke(command, [TIGER, *options])
    assert done.exit_code != Exit.OK
    return done.output


def test_what_cannot_be_drawn_is_refused_before_anything_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "ends with one of .svg, .pdf, .png, .json" in refusal("--graph-file", "graph.gif")
    assert "at most 300 nodes" in refusal("--graph-file", "graph.svg", "--graph", "301")
    monkeypatch.setattr(policy_drawing, "missing_libraries", lambda: ["networkx"])
    assert "drawing needs networkx: pip install 'hypgen[draw]'" in refusal("--graph-file", "graph.svg")
