# SPDX-License-Identifier: Apache-2.0
"""Figures as SVG without colours of their own: classes name the modes, and the page's style paints them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from hypgen.experiments.reports.figures import SUCCESS, Figure, Mark, Panel, Point, Series
from hypgen.experiments.reports.scale import Scale, scale_of, tick_label
from hypgen.experiments.statistics import Interval
from hypgen.experiments.suite_values import MODES

WIDTH, HEIGHT = 460, 300
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 18, 36, 46
_ROW, _TALL_ROW = 26, 42  # of dots: with the label beside, and above
_BESIDE = 21  # letters of a label that stand beside dots
_LABELS = 160  # pixels for them
_BESIDE_EACH_OTHER = 2.5  # pixels between the points of two lines at one place
_APART = 36  # pixels between ticks that stand at values
_CORNERS = {"default": 4, "rollout": 3, "despot": 0, "parallel": -4, "pomcp": -3, "gpu": 5, "hyp": 6}


def panel(figure: Figure, one: Panel) -> str:
    """Return a panel of a figure."""
    return _curves(figure, one) if figure.axis else _dots(one)


def height_of(drawn: str) -> float:
    """Return the height of a panel that was drawn, in pixels at its width."""
    return float(drawn.partition(f'viewBox="0 0 {WIDTH} ')[2].partition('"')[0])


def swatch(mode: str, variant: int) -> str:
    """Return the piece of a line that a legend shows."""
    body = f'<path class="line v{variant % 4}" d="M1 8H35"/>{_marker(mode, 18, 8)}'
    return f'<svg class="swatch m-{mode}" viewBox="0 0 36 16" aria-hidden="true">{body}</svg>'


def published_swatch(mode: str) -> str:
    """Return how a legend shows a published value."""
    return (
        f'<svg class="swatch {_class(mode)}" viewBox="0 0 36 16" aria-hidden="true">{_diamond(18, 8)}</svg>'
    )


def promise(returned: Interval, promised: float, low: float, high: float, mode: str) -> str:
    """Return a small plot for a table's row: what was earned, and as a ring what the root promised."""
    scale = Scale(low, high, 8, 132, False)
    x, y = scale(returned.mean), 10
    parts = [f'<path class="rule" d="M8 {y}H132"/>']
    if not math.isnan(promised):
        parts.append(f'<path class="gap" d="M{x:.1f} {y}H{scale(promised):.1f}"/>')
        parts.append(f'<circle class="ring" cx="{scale(promised):.1f}" cy="{y}" r="4.5"/>')
    if returned.is_known:
        parts.append(f'<path class="whisker" d="M{scale(returned.low):.1f} {y}H{scale(returned.high):.1f}"/>')
    parts.append(f'<circle class="mark" cx="{x:.1f}" cy="{y}" r="3.5"/>')
    text = f"earned {returned.mean:.4g}" + ("" if math.isnan(promised) else f", promised {promised:.4g}")
    return (
        f'<svg class="promise m-{mode}" viewBox="0 0 140 20" role="img"><title>{text}</title>'
        f"{''.join(parts)}</svg>"
    )


def _curves(figure: Figure, one: Panel) -> str:
    lines = [line for line in one.series if not line.is_level]
    # All panels of a figure have one axis, so that they can be read above each other.
    everywhere = [line for each in figure.panels for line in each.series if not line.is_level]
    places = sorted({point.x for line in everywhere for point in line.points})
    marked = [mark.point.x for each in figure.panels for mark in each.marks]
    across = scale_of([*places, *marked], _LEFT, WIDTH - _RIGHT, figure.is_log)
    up = _up(figure, one)
    parts = [_heading(one), _grid(one, up), _ticks(across, places, HEIGHT - _BOTTOM)]
    middle = (_LEFT + WIDTH - _RIGHT) / 2
    parts.append(f'<text class="label" x="{middle:.0f}" y="{HEIGHT - 8}">{escape(figure.axis)}</text>')
    parts += [_level(line, up) for line in one.series if line.is_level]
    parts += [
        _line(line, across, up, _BESIDE_EACH_OTHER * (i - (len(lines) - 1) / 2))
        for i, line in enumerate(lines)
    ]
    parts += [_published(mark, across(mark.point.x), up(mark.point.y.mean), up) for mark in one.marks]
    return _svg(one, HEIGHT, parts)


def _up(figure: Figure, one: Panel) -> Scale:
    """Return the scale of a panel, which all panels of its quantity share."""
    if one.quantity == SUCCESS.name:
        return scale_of([0.0, 1.0], HEIGHT - _BOTTOM, _TOP)
    alike = [each for each in figure.panels if each.quantity == one.quantity]
    points = [point for each in alike for line in each.series for point in line.points]
    points += [mark.point for each in alike for mark in each.marks]
    values = [value for point in points for value in (point.y.mean, point.y.low, point.y.high)]
    return scale_of(values, HEIGHT - _BOTTOM, _TOP, one.is_log)


def _grid(one: Panel, up: Scale) -> str:
    parts = []
    for value in up.ticks(5):
        y = up(value)
        parts.append(f'<path class="rule" d="M{_LEFT} {y:.1f}H{WIDTH - _RIGHT}"/>')
        parts.append(f'<text class="tick y" x="{_LEFT - 7}" y="{y + 4:.1f}">{_tick(one, value)}</text>')
    return "".join(parts)


def _tick(one: Panel, value: float) -> str:
    return f"{100 * value:.0f} %" if one.quantity == SUCCESS.name else tick_label(value)


def _ticks(across: Scale, places: Sequence[float], y: float) -> str:
    """Return the ticks below a panel: at the values that were played, where they are far enough apart."""
    apart = [across(b) - across(a) for a, b in zip(places, places[1:], strict=False)]
    values = places if 1 < len(places) <= 8 and min(apart) >= _APART else across.ticks(6)
    parts = [f'<path class="axis" d="M{_LEFT} {y:.1f}H{WIDTH - _RIGHT}"/>']
    for value in values:
        x = across(value)
        parts.append(f'<path class="axis" d="M{x:.1f} {y:.1f}v4"/>')
        parts.append(f'<text class="tick" x="{x:.1f}" y="{y + 18:.1f}">{tick_label(value)}</text>')
    return "".join(parts)


def _level(line: Series, up: Scale) -> str:
    point = line.points[0]
    y, left, right = up(point.y.mean), _LEFT, WIDTH - _RIGHT
    band = ""
    if point.y.is_known:
        top, bottom = up(point.y.high), up(point.y.low)
        band = f'<path class="band" d="M{left} {top:.1f}H{right}V{bottom:.1f}H{left}Z"/>'
    body = f'{band}<path class="line level v{line.variant % 4}" d="M{left} {y:.1f}H{right}"/>'
    return f'<g class="m-{line.mode}">{_title(point)}{body}{_marker(line.mode, right - 6, y)}</g>'


def _line(line: Series, across: Scale, up: Scale, aside: float) -> str:
    """Return a line, moved aside a little so that intervals at one place do not hide each other."""
    at = [(across(point.x) + aside, up(point.y.mean)) for point in line.points]
    parts = []
    for point, (x, _) in zip(line.points, at, strict=True):
        if point.y.is_known:
            parts.append(f'<path class="whisker" d="M{x:.1f} {up(point.y.low):.1f}V{up(point.y.high):.1f}"/>')
    if len(at) > 1:
        way = "L".join(f"{x:.1f} {y:.1f}" for x, y in at)
        parts.append(f'<path class="line v{line.variant % 4}" d="M{way}"/>')
    for point, (x, y) in zip(line.points, at, strict=True):
        parts.append(f"<g>{_title(point)}{_marker(line.mode, x, y)}</g>")
    return f'<g class="m-{line.mode}">{"".join(parts)}</g>'


def _published(mark: Mark, x: float, y: float, up: Scale) -> str:
    interval = ""
    if mark.point.y.is_known:
        interval = (
            f'<path class="whisker" d="M{x:.1f} {up(mark.point.y.low):.1f}V{up(mark.point.y.high):.1f}"/>'
        )
    letter = f'<text class="letter" x="{x + 9:.1f}" y="{y - 6:.1f}">{mark.letter}</text>'
    return f'<g class="{_class(mark.mode)}">{_title(mark.point)}{interval}{_diamond(x, y)}{letter}</g>'


def _dots(one: Panel) -> str:
    rows: list[tuple[str, str, Point, bool]] = [
        (line.label, f"m-{line.mode}", point, False) for line in one.series for point in line.points
    ]
    rows += [(f"{mark.letter}, published", _class(mark.mode), mark.point, True) for mark in one.marks]
    is_beside = max(len(label) for label, *_ in rows) <= _BESIDE
    step, left = (_ROW, _LABELS) if is_beside else (_TALL_ROW, 14)
    bottom = _TOP + step * len(rows)
    values = [value for _, _, point, _ in rows for value in (point.y.mean, point.y.low, point.y.high)]
    values += [0.0, 1.0] if one.quantity == SUCCESS.name else []
    across = scale_of(values, left, WIDTH - _RIGHT, one.is_log)
    parts = [_heading(one)]
    for value in across.ticks(5):
        x = across(value)
        parts.append(f'<path class="rule" d="M{x:.1f} {_TOP - 6}V{bottom}"/>')
        parts.append(f'<text class="tick" x="{x:.1f}" y="{bottom + 18}">{_tick(one, value)}</text>')
    for i, (label, css, point, is_published) in enumerate(rows):
        y = _TOP + step * i + (step / 2 if is_beside else step - 14)
        text_at = f'x="{left - 12}" y="{y + 4:.1f}"' if is_beside else f'x="0" y="{y - 11:.1f}"'
        text = f'<text class="name{"" if is_beside else " above"}" {text_at}>{escape(label)}</text>'
        x = across(point.y.mean)
        interval = ""
        if point.y.is_known:
            interval = (
                f'<path class="whisker" d="M{across(point.y.low):.1f} {y:.1f}H{across(point.y.high):.1f}"/>'
            )
        mode = css.removeprefix("m-")
        marker = _diamond(x, y) if is_published else _marker(mode, x, y)
        note = ""
        if point.note:
            side, anchor = (9, "start") if x < WIDTH - 110 else (-9, "end")
            place = f'x="{x + side:.1f}" y="{y + 4.5:.1f}"'
            note = f'<text class="beside" text-anchor="{anchor}" {place}>{escape(point.note)}</text>'
        parts.append(f'{text}<g class="{css}">{_title(point)}{interval}{marker}{note}</g>')
    return _svg(one, bottom + 30, parts)


def _svg(one: Panel, height: float, parts: Sequence[str]) -> str:
    name = escape(one.quantity)
    return (
        f'<svg class="panel" viewBox="0 0 {WIDTH} {height:.0f}" role="img" aria-label="{name}">'
        f"{''.join(parts)}</svg>"
    )


def _heading(one: Panel) -> str:
    notes = [escape(one.about)] * bool(one.about) + ["logarithmic"] * one.is_log
    note = "".join(f'<tspan class="note">, {text}</tspan>' for text in notes)
    return f'<text class="quantity" x="0" y="15">{escape(one.quantity)}{note}</text>'


def _title(point: Point) -> str:
    return f"<title>{escape(point.text)}</title>"


def _class(mode: str) -> str:
    return f"m-{mode}" if mode in MODES else "m-published"


def _marker(mode: str, x: float, y: float) -> str:
    """Return a mode's own shape, so that lines are told apart without colour."""
    corners = _CORNERS.get(mode, 0)
    if corners == 0:
        return f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="4"/>'
    count, radius = abs(corners), 5.2
    turn = {4: math.pi / 4, 3: -math.pi / 2, -4: 0.0, -3: math.pi / 2}.get(corners, -math.pi / 2)
    angles = (turn + 2.0 * math.pi * i / count for i in range(count))
    way = "L".join(f"{x + radius * math.cos(a):.1f} {y + radius * math.sin(a):.1f}" for a in angles)
    return f'<path class="mark" d="M{way}Z"/>'


def _diamond(x: float, y: float) -> str:
    return f'<path class="open" d="M{x:.1f} {y - 6.5:.1f}l6.5 6.5l-6.5 6.5l-6.5 -6.5Z"/>'
