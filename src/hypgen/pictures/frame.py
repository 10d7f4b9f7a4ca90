# SPDX-License-Identifier: Apache-2.0
"""One step of an episode as a figure: the world, what was done and seen, gauges and curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hypgen.pictures.shapes import GRID, GROUND, INK, draw_gauges, draw_world

_WIDE = 3.6  # inches of the world's longer side
_STRIP = 0.5  # of the words above it
_GAUGE = 0.24  # of each gauge
_CURVES = 1.0
_SMALL = 7
_LETTERS = 54  # in a line


def frame(view: Mapping[str, Any], number: int) -> Figure:
    """Return the figure of step ``number`` of view data; the number of steps means the end."""
    steps, scene = view["steps"], view.get("scene") or {"extent": None, "static": []}
    ended = number >= len(steps)
    moment: Mapping[str, Any] = (view.get("end") or {}) if ended else steps[number]
    gauges = [
        s for s in [*(moment.get("truth") or []), *(moment.get("belief") or [])] if s["shape"] == "gauge"
    ]
    rows = len({s.get("text") or s["name"] for s in gauges})
    heights = [_STRIP, _world_height(scene), rows * _GAUGE + 0.1 * bool(rows), _CURVES * _has_curves(steps)]
    figure = Figure(figsize=(_WIDE + 0.3, sum(heights) + 0.2), facecolor=GROUND)
    areas = _areas(figure, heights)
    _words(areas[0], view, number)
    if scene["extent"]:
        draw_world(areas[1], scene, moment)
    if rows:
        draw_gauges(areas[2], gauges)
    if _has_curves(steps):
        # What a step limit cuts off has earned less than the bounds speak of.
        _curves(areas[3], steps, number, has_earned=view.get("ended") != "step_limit")
    return figure


def _world_height(scene: Mapping[str, Any]) -> float:
    extent = scene["extent"]
    if not extent:
        return 0.0
    wide, tall = (e[1] - e[0] + bool(extent["cells"]) for e in (extent["x"], extent["y"]))
    return float(min(_WIDE * max(tall, wide / 12) / wide, 1.2 * _WIDE))


def _areas(figure: Figure, heights: Sequence[float]) -> list[Axes]:
    """Return axes below each other, of these heights in inches."""
    tall, wide = figure.get_figheight(), figure.get_figwidth()
    top = tall - 0.05
    areas: list[Axes] = []
    for height in heights:
        areas.append(
            figure.add_axes(
                (0.15 / wide, (top - height) / tall, _WIDE / wide, max(height - 0.05, 0.01) / tall)
            )
        )
        top -= height
        areas[-1].set_visible(height > 0)
    return areas


def _words(axes: Axes, view: Mapping[str, Any], number: int) -> None:
    axes.axis("off")
    steps = view["steps"]
    if number >= len(steps):
        earned = sum(s.get("reward") or 0 for s in steps)
        lines = [f"the end, after {len(steps)} steps", f"earned {earned:.4g}"]
    else:
        step = steps[number]
        reward = step.get("reward")
        seen = ", ".join(f"{name} {_text(value)}" for name, value in (step.get("seen") or {}).items())
        lines = [
            f"step {step.get('step', number)}: {step['action']}",
            "" if reward is None else f"reward {reward:.4g}" + (f"; seen {seen}" if seen else ""),
        ]
    for place, (line, size) in enumerate(zip(lines, (9, _SMALL), strict=True)):
        text = line if len(line) <= _LETTERS else line[: _LETTERS - 2] + " .."
        axes.text(0, 0.95 - 0.5 * place, text, fontsize=size, va="top", color=INK, transform=axes.transAxes)


def _text(value: Any) -> str:
    """Return what was seen as the language writes it; many bools as discs, as on the page."""
    if isinstance(value, list) and value and all(isinstance(one, bool) for one in value):
        return "".join("●" if one else "○" for one in value)
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    return (
        str(value).lower()
        if isinstance(value, bool)
        else f"{value:.4g}"
        if isinstance(value, float)
        else str(value)
    )


def _has_curves(steps: Sequence[Mapping[str, Any]]) -> bool:
    return any(step.get("upper") is not None or step.get("lower") is not None for step in steps)


def _curves(axes: Axes, steps: Sequence[Mapping[str, Any]], number: int, *, has_earned: bool) -> None:
    """Draw the bounds of each decision, and what was earned from there."""
    colours = {"upper": "#0072b2", "lower": "#d55e00"} | ({"earned": INK} if has_earned else {})
    for name, colour in colours.items():
        known = [(i, s[name]) for i, s in enumerate(steps) if s.get(name) is not None]
        if known:
            axes.plot(*zip(*known, strict=True), color=colour, linewidth=1, label=name)
    axes.axvline(min(number, len(steps) - 1), color="#9a9a9a", linewidth=0.8)
    axes.tick_params(labelsize=5, length=2, pad=1)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    left, low, wide, tall = axes.get_position().bounds  # the numbers stand left of it
    axes.set_position((left + 0.06, low + 0.02, wide - 0.06, 0.84 * tall - 0.02))  # and the names above
    axes.legend(
        fontsize=5, frameon=False, loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.2, ncols=3
    )
    for side in axes.spines.values():
        side.set_color(GRID)
