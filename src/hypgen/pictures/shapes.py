# SPDX-License-Identifier: Apache-2.0
"""Shapes of a scene as matplotlib draws them: what is true is solid, what is believed pale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib import patches
from matplotlib.axes import Axes
from matplotlib.transforms import Affine2D

from hypgen.dsl.types.palette import PALETTE

Shape = Mapping[str, Any]
INK, GROUND, GRID = "#1f1f1f", "#ffffff", "#dddddd"
_RADIUS = 0.32  # of a marker, in cells
_PLANE = 0.016  # a marker's radius in a plane, as a share of the picture
_PALE = 0.55  # the opacity of what is believed for sure


def draw_world(axes: Axes, scene: Mapping[str, Any], moment: Mapping[str, Any]) -> None:
    """Draw a moment (``truth`` and ``belief``) of a scene that has an extent."""
    extent = scene["extent"]
    margin = 0.5 if extent["cells"] else 0.0
    (left, right), (low, high) = ([e[0] - margin, e[1] + margin] for e in (extent["x"], extent["y"]))
    axes.set(xlim=(left, right), ylim=(low, high), xticks=[], yticks=[], aspect="equal")
    for side in axes.spines.values():
        side.set_color(GRID)
    unit = 1.0 if extent["cells"] else max(right - left, high - low) * _PLANE / _RADIUS
    if extent["cells"]:
        _grid(axes, extent)
    believed = moment.get("belief") or []
    names = {shape["name"] for shape in believed}
    for level, shape in enumerate([*scene["static"], *believed, *(moment.get("truth") or [])], 1):
        _draw(axes, shape, unit, level, outlined="p" not in shape and shape["name"] in names)


def draw_gauges(axes: Axes, gauges: Sequence[Shape]) -> None:
    """Draw gauges as bars, those of a belief pale."""
    axes.set(xlim=(0, 1), ylim=(len({_row(g) for g in gauges}) - 0.4, -0.6), xticks=[], yticks=[])
    axes.axis("off")
    rows = {row: number for number, row in enumerate(dict.fromkeys(map(_row, gauges)))}
    for number in rows.values():
        axes.barh(number, 1, height=0.4, color="#eeeeee")
    for gauge in gauges:
        span = gauge["high"] - gauge["low"]
        share = min(1.0, max(0.0, (gauge["value"] - gauge["low"]) / span)) if span > 0 else 0.0
        y, colour = rows[_row(gauge)], PALETTE[gauge["colour"]][0]
        if "p" in gauge:
            axes.barh(y, 0.012, left=share - 0.006, height=0.4, color=colour, alpha=_alpha(gauge["p"]))
            continue
        axes.barh(y, share, height=0.16, color=colour)
        axes.text(0, y - 0.26, f"{_row(gauge)}: {gauge['value']:.3g}", fontsize=7, va="bottom", color=INK)


def _row(gauge: Shape) -> str:
    return str(gauge.get("text") or gauge["name"])


def _grid(axes: Axes, extent: Mapping[str, Any]) -> None:
    for x in range(int(extent["x"][0]), int(extent["x"][1]) + 2):
        axes.axvline(x - 0.5, color=GRID, linewidth=0.4, zorder=0)
    for y in range(int(extent["y"][0]), int(extent["y"][1]) + 2):
        axes.axhline(y - 0.5, color=GRID, linewidth=0.4, zorder=0)


def _alpha(p: float) -> float:
    return 0.06 + (_PALE - 0.06) * math.sqrt(p)


def _draw(axes: Axes, shape: Shape, unit: float, level: int, *, outlined: bool) -> None:
    """Draw a shape over those of lower levels; ``outlined`` tells what is true from what is believed."""
    if shape["shape"] == "gauge":
        return
    x, y, colour = shape["x"], shape["y"], PALETTE[shape["colour"]][0]
    style: dict[str, Any] = {"facecolor": colour, "edgecolor": "none", "zorder": level}
    alpha = _alpha(shape["p"]) if "p" in shape else None
    if alpha is not None:
        style["alpha"] = alpha
    elif outlined:
        style |= {"edgecolor": INK, "linewidth": 0.8}
    match shape["shape"]:
        case "cell":
            side = 0.84 if outlined else 0.96
            axes.add_patch(patches.Rectangle((x - side / 2, y - side / 2), side, side, **style))
        case "rectangle":
            wide, tall = shape["width"], shape["height"]
            box = patches.Rectangle((x - wide / 2, y - tall / 2), wide, tall, **style)
            turn = Affine2D().rotate_around(x, y, shape.get("heading") or 0.0)
            box.set_transform(turn + axes.transData)
            axes.add_patch(box)
        case "marker":
            _marker(axes, shape, unit, style)
        case "line":
            ends = [x, shape["x2"]], [y, shape["y2"]]
            axes.plot(*ends, color=colour, alpha=alpha, linewidth=2, zorder=level)
    # The library cannot render letters that are far outside.
    if shape.get("text") and alpha is None and _is_inside(axes, x, y):
        light = shape["shape"] == "label" or shape["colour"] in ("white", "yellow", "sky", "orange", "grey")
        axes.text(
            x, y, shape["text"], color=INK if light else GROUND, fontsize=_size(axes, unit), ha="center",
            va="center", clip_on=True, zorder=level,
        )  # fmt: skip


def _is_inside(axes: Axes, x: float, y: float) -> bool:
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    return left <= x <= right and low <= y <= high


def _marker(axes: Axes, shape: Shape, unit: float, style: Mapping[str, Any]) -> None:
    x, y, radius = shape["x"], shape["y"], _RADIUS * unit
    heading = shape.get("heading")
    if heading is not None:
        tip = [
            (x + reach * radius * math.cos(heading + turn), y + reach * radius * math.sin(heading + turn))
            for reach, turn in ((1.6, 0.0), (1.0, 1.2), (1.0, -1.2))
        ]
        axes.add_patch(patches.Polygon(tip, **style))
    axes.add_patch(patches.Circle((x, y), radius, **style))


def _size(axes: Axes, unit: float) -> float:
    """Return the size of letters, in points, that fits a cell."""
    left, right = axes.get_xlim()
    low, high = axes.get_ylim()
    figure = axes.get_figure(root=True)
    assert figure is not None
    box = axes.get_position()
    inches = min(
        box.width * figure.get_figwidth() / (right - left), box.height * figure.get_figheight() / (high - low)
    )
    return max(4.0, min(11.0, 72 * inches * unit * 0.5))
