# SPDX-License-Identifier: Apache-2.0
"""A figure as an SVG file that stands alone: its legend, its panels, and the style that paints them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from html import escape
from importlib.resources import files

from hypgen.experiments.reports import svg
from hypgen.experiments.reports.figures import Figure, Mark, Series

_COLUMNS = 2
_GAP, _MARGIN = 28, 14
_LETTER = 7.2  # a letter's width at most, in pixels
_LEGEND_ROW = 22
_FONT = "system-ui, 'Segoe UI', 'Liberation Sans', Roboto, Arial, sans-serif"


@cache
def figure_style() -> str:
    """Return the style of figures, which a page needs too."""
    colours = files("hypgen").joinpath("colours.css").read_text()
    return colours + files("hypgen.experiments.reports").joinpath("figures.css").read_text()


def legend_of(figure: Figure) -> list[tuple[str, str]]:
    """Return a swatch and a label for each line and each published value; single settings need none."""
    if not figure.axis:
        return []
    first: dict[str, Series] = {}
    marks: dict[str, Mark] = {}
    for panel in figure.panels:
        first |= {line.label: line for line in panel.series if line.label not in first}
        marks |= {mark.letter: mark for mark in panel.marks}
    lines = [(svg.swatch(line.mode, line.variant), line.label) for line in first.values()]
    return lines + [
        (svg.published_swatch(mark.mode), f"{mark.letter}: {mark.label}, published")
        for mark in marks.values()
    ]


def figure_file(figure: Figure) -> str:
    """Return the text of an SVG file with all panels of a figure."""
    panels = [svg.panel(figure, panel) for panel in figure.panels]
    columns = min(_COLUMNS, len(panels))
    width = 2 * _MARGIN + columns * svg.WIDTH + (columns - 1) * _GAP
    parts, y = _legend(legend_of(figure), width)
    for start in range(0, len(panels), columns):
        row = panels[start : start + columns]
        for i, panel in enumerate(row):
            parts.append(_at(_MARGIN + i * (svg.WIDTH + _GAP), y, svg.WIDTH, svg.height_of(panel), panel))
        y += max(map(svg.height_of, row)) + _GAP
    height = y - _GAP + _MARGIN
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height:.0f}" '
        f'width="{width}" height="{height:.0f}" font-family="{_FONT}">\n'
        f"<style>\n{figure_style()}</style>\n"
        f'<rect width="100%" height="100%" style="fill: var(--paper)"/>\n' + "\n".join(parts) + "\n</svg>\n"
    )


def _legend(legend: Sequence[tuple[str, str]], width: float) -> tuple[list[str], float]:
    """Return a legend's entries in rows of a width, and where they end."""
    parts: list[str] = []
    x, y = float(_MARGIN), float(_MARGIN)
    for swatch, label in legend:
        needed = 44 + _LETTER * len(label)
        if x > _MARGIN and x + needed > width - _MARGIN:
            x, y = float(_MARGIN), y + _LEGEND_ROW
        parts.append(_at(x, y, 36, 16, swatch))
        parts.append(f'<text x="{x + 42:.0f}" y="{y + 12.5:.1f}">{escape(label)}</text>')
        x += needed + 16
    return parts, y + (_LEGEND_ROW + 8 if legend else 0)


def _at(x: float, y: float, width: float, height: float, inner: str) -> str:
    return f'<svg x="{x:.0f}" y="{y:.0f}" width="{width:.0f}" height="{height:.0f}">{inner}</svg>'
