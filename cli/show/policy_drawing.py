# SPDX-License-Identifier: Apache-2.0
"""Draws a policy's graph, as the exact solver's program gives it, into a file."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

SUFFIXES = (".svg", ".pdf", ".png")
MOST_NODES = 300

_SHOWN_OBSERVATIONS = 2
_WIDTH = 24  # of a line of a label
_START, _END, _REST = "start", "end", "..."
_COLOURS: dict[int | str, str] = {_START: "#d9ead3", _END: "#eeeeee", _REST: "#eeeeee"}
_PIXELS = 30000  # on the longer side of an image


def missing_libraries() -> list[str]:
    """Return the libraries that drawing needs and that are not installed."""
    return [name for name in ("matplotlib", "networkx") if find_spec(name) is None]


def draw(graph: dict[str, Any], title: str, suffix: str) -> bytes:
    """Return the drawing of a graph; the suffix of its file says how. Equal graphs give equal SVG."""
    import matplotlib
    import networkx
    from matplotlib.figure import Figure

    drawn = networkx.DiGraph()
    for source, target, label in _edges(graph):
        drawn.add_edge(source, target, label=label)
    texts = {node["node"]: f"{node['node']} {node['action']}" for node in graph["nodes"]}
    texts |= {_START: "start", _END: "the end"}
    texts[_REST] = f"{graph['nodes_left_out']}{' or more' if graph['may_have_more'] else ' more'}"
    layers = _layers(drawn)
    widest = max(map(len, layers))
    places = {
        node: (i - (len(nodes) - 1) / 2, -float(layer))
        for layer, nodes in enumerate(layers)
        for i, node in enumerate(nodes)
    }
    with matplotlib.rc_context({"svg.hashsalt": "hypgen", "svg.fonttype": "none"}):
        size = (3.2 * widest + 1, 1.8 * len(layers) + 1)
        axes = (figure := Figure(figsize=size)).add_subplot()
        axes.set_title(title)
        axes.set_axis_off()
        ways = {"ax": axes, "node_size": 1600, "connectionstyle": "arc3,rad=0.15"}
        networkx.draw_networkx_edges(drawn, places, edge_color="#777777", **ways)
        labels = {(a, b): label for a, b, label in drawn.edges(data="label")}
        networkx.draw_networkx_edge_labels(drawn, places, labels, 0.4, font_size=7, rotate=False, **ways)
        for node, (x, y) in places.items():
            box = {"boxstyle": "round", "facecolor": _COLOURS.get(node, "#cfe2f3"), "edgecolor": "#555555"}
            text = _wrapped(texts[node])
            axes.text(x, y, text, ha="center", va="center", fontsize=9, bbox=box, parse_math=False)
        axes.set_xlim(-widest / 2, widest / 2)
        axes.set_ylim(0.5 - len(layers), 0.5)
        drawing, dpi = io.BytesIO(), min(100.0, _PIXELS / max(size))
        metadata = {"Date": None} if suffix == ".svg" else None
        figure.savefig(drawing, format=suffix[1:], bbox_inches="tight", metadata=metadata, dpi=dpi)
    return drawing.getvalue()


def _edges(graph: dict[str, Any]) -> Iterator[tuple[int | str, int | str, str]]:
    """Yield what leads where; several ways to one place have one label."""
    found: dict[tuple[int | str, int | str], list[str]] = {}
    for start in graph["starts"]:
        text = _label([start["seen"]] if start["seen"] else [], 0, start["probability"])
        found.setdefault((_START, start["to"] or _REST), []).append(text)
    for node in graph["nodes"]:
        for edge in node["edges"]:
            text = _label(edge["observations"], edge["observations_left_out"], edge["probability"])
            found.setdefault((node["node"], edge["to"] or _REST), []).append(text)
        if node["ends"] > 0:
            found.setdefault((node["node"], _END), []).append(f"{node['ends']:.3g}")
    for (source, target), texts in found.items():
        more = [f"and {len(texts) - 2} more"] if len(texts) > 2 else []
        yield source, target, "\n".join(texts[:2] + more)


def _label(observations: list[str], left_out: int, probability: float) -> str:
    shown = observations[:_SHOWN_OBSERVATIONS]
    left_out += len(observations) - len(shown)
    more = [f"and {left_out} more"] if left_out else []
    return "\n".join([*map(_wrapped, shown + more), f"{probability:.3g}"])


def _wrapped(text: str) -> str:
    return "\n".join(textwrap.wrap(text, _WIDTH)) or text


def _layers(graph: Any) -> list[list[int | str]]:
    """Return the nodes by their distance from the start; each near those that lead to it."""
    last: list[int | str] = [node for node in (_END, _REST) if node in graph]
    layers: list[list[int | str]] = [[_START]]
    seen: set[int | str] = {_START, *last}
    while layers[-1]:
        following = dict.fromkeys(n for node in layers[-1] for n in graph.successors(node) if n not in seen)
        seen.update(following)
        layers.append(list(following))
    layers[-1] = last
    return layers if last else layers[:-1]
