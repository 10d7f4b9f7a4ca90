# SPDX-License-Identifier: Apache-2.0
"""A scene of cells as lines of text, two characters a cell; in colour for those who read it in a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import click

from hypgen.dsl.types.palette import PALETTE

_SHADES = " ░▒▓█"
_BAR = 20  # characters of a gauge
_ARROWS = ">^<v"
_DARK = frozenset(("blue", "red", "green", "black", "brown", "grey"))  # under white letters

Shape = Mapping[str, Any]


@dataclass
class _Cell:
    """What stands in a cell: a glyph, the colour of its ground, and that of its letter."""

    glyph: str = "."
    ground: tuple[int, int, int] = (255, 255, 255)
    ink: str = "black"


def scene_lines(scene: Mapping[str, Any], moment: Mapping[str, Any], *, coloured: bool) -> list[str]:
    """Return a moment (``truth`` and ``belief``) of a scene as lines: cells, if it has any, then gauges.

    Without colour, what is believed is shaded: ``░``, ``▒``, ``▓`` and ``█`` for up to 1/4, 1/2, 3/4 and 1.
    """
    shapes = [*scene["static"], *moment.get("belief", ()), *moment.get("truth", ())]
    extent = scene["extent"]
    lines = [] if extent is None or not extent["cells"] else _grid(extent, shapes, coloured=coloured)
    return lines + [_gauge(s) for s in moment.get("truth", ()) if s["shape"] == "gauge"]


def _grid(extent: Mapping[str, Any], shapes: Sequence[Shape], *, coloured: bool) -> list[str]:
    (left, right), (low, high) = extent["x"], extent["y"]
    cells = {(x, y): _Cell() for x in range(left, right + 1) for y in range(low, high + 1)}
    believed: dict[tuple[int, int], float] = {}
    for shape in shapes:
        if "x" not in shape or shape["shape"] not in ("cell", "marker", "label"):
            continue
        place = round(shape["x"]), round(shape["y"])
        cell = cells.get(place)
        if cell is None:
            continue
        if "p" in shape:
            believed[place] = min(1.0, believed.get(place, 0.0) + shape["p"])
            cell.ground = _mixed(cell.ground, shape["colour"], 0.75 * shape["p"])
            cell.glyph = cell.glyph if coloured else _SHADES[math.ceil(4 * believed[place])]
        else:
            _put(cell, shape)
    rows = range(high, low - 1, -1)
    if not coloured:
        return ["  " + " ".join(cells[x, y].glyph for x in range(left, right + 1)).rstrip() for y in rows]
    return ["  " + "".join(_styled(cells[x, y]) for x in range(left, right + 1)) for y in rows]


def _put(cell: _Cell, shape: Shape) -> None:
    """Put what is true into a cell: its ground is coloured by cells, its letter by the rest."""
    heading = shape.get("heading")
    arrow = None if heading is None else _ARROWS[round(2 * heading / math.pi) % 4]
    given = str(shape.get("text") or "")[:1]
    cell.glyph = given or arrow or {"cell": "#", "marker": "o"}.get(shape["shape"], " ")
    if shape["shape"] != "label":
        cell.ground = _rgb(shape["colour"])
        cell.ink = "white" if shape["colour"] in _DARK else "black"


def _styled(cell: _Cell) -> str:
    glyph = " " if cell.glyph in ".#" else cell.glyph
    return click.style(f"{glyph} ", fg=_rgb(cell.ink), bg=cell.ground)


def _rgb(colour: str) -> tuple[int, int, int]:
    value = PALETTE[colour][0]
    return int(value[1:3], 16), int(value[3:5], 16), int(value[5:7], 16)


def _mixed(ground: tuple[int, int, int], colour: str, share: float) -> tuple[int, int, int]:
    red, green, blue = (round(a + share * (b - a)) for a, b in zip(ground, _rgb(colour), strict=True))
    return red, green, blue


def _gauge(shape: Shape) -> str:
    span = shape["high"] - shape["low"]
    share = min(1.0, max(0.0, (shape["value"] - shape["low"]) / span)) if span > 0 else 0.0
    full = round(share * _BAR)
    name = shape.get("text") or shape["name"]
    return f"  {name} [{'=' * full}{'-' * (_BAR - full)}] {shape['value']:.3g}"
