# SPDX-License-Identifier: Apache-2.0
"""What a model draws: shapes, their fields, and whether they lie in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.scope.unit_checks import require_plain, require_same
from hypgen.dsl.check.terms.quantifiers import bind_all, bind_types
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e02_names, e03_types, e08_drawings, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, Float, Int
from hypgen.dsl.types.palette import COLOUR

Placed = list[tuple[ir.Expr, Span]]


@dataclass(frozen=True)
class Shape:
    """The fields that a shape needs, and those that it may have."""

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()

    @property
    def fields(self) -> tuple[str, ...]:
        """Return the names of all fields."""
        return self.needed + self.optional


AREA = "area"
SHAPES = {
    AREA: Shape(("x", "y", "x2", "y2")),
    "cell": Shape(("x", "y", "colour"), ("text",)),
    "marker": Shape(("x", "y", "colour"), ("heading", "text")),
    "rectangle": Shape(("x", "y", "width", "height", "colour"), ("heading", "text")),
    "line": Shape(("x", "y", "x2", "y2", "colour")),
    "label": Shape(("x", "y", "text"), ("colour",)),
    "gauge": Shape(("value", "low", "high"), ("colour", "text")),
}
_AXES = {"x": "x", "x2": "x", "y": "y", "y2": "y"}
_LENGTHS = (*_AXES, "width", "height")


def drawings(program: Program) -> list[ir.Drawing]:
    """Return what the model draws, in order; those with mistakes are left out."""
    found: list[ir.Drawing] = []
    seen: dict[str, ast.Draw] = {}
    items = [i for i in program.file.items if isinstance(i, ast.Draw)]
    positions: Placed = []
    for item in items:
        if item.name in seen:
            first = seen[item.name].span
            program.report.add(Mistake(e02_names.duplicate(f"draw {item.name}", item.span, first)))
            continue
        seen[item.name] = item
        drawing = program.report.attempt(partial(_drawing, item, program, positions))
        if drawing is not None:
            found.append(drawing)
    if len(found) == len(items):
        program.report.attempt(partial(_check_places, found, items))
    return found


def _drawing(item: ast.Draw, program: Program, positions: Placed) -> ir.Drawing:
    """Return a checked drawing; ``positions`` are those of others, whose unit this one's must have."""
    shape = SHAPES.get(item.shape)
    if shape is None:
        raise Mistake(e08_drawings.unknown_shape(item.shape, list(SHAPES), item.shape_span))
    _check_names(item, shape)
    if item.shape == AREA:
        if item.binders:
            raise Mistake(e08_drawings.area_with_members(item.binders[0].span))
        scope = Scope(program, evaluate=True, constant=True)
    else:
        scope = Scope(program, owner=Owner("draw", item.name))
    binders = bind_types(item.binders, scope)
    scope = bind_all(item.binders, binders, scope)
    where: ir.Expr = operators.TRUE
    if item.where is not None:
        where = check_as(item.where, scope, BOOL, "the condition after 'where'")
        scope = scope.given(where)
    values = gather([partial(_field, item.shape, f, scope) for f in item.fields])
    fields = dict(zip((f.name for f in item.fields), values, strict=True))
    spans = {f.name: f.value.span for f in item.fields}
    here = [(e, spans[n]) for n, e in fields.items() if n in _LENGTHS and isinstance(e, ir.Expr)]
    if here:
        require_same([*positions, *here], "lie in one picture")
        positions += here
    measured = [
        (e, spans[n]) for n, e in fields.items() if n in ("value", "low", "high") and isinstance(e, ir.Expr)
    ]
    if measured:
        require_same(measured, "stand on one gauge")
    return ir.Drawing(item.name, item.shape, binders, where, fields, item.span)


def _check_names(item: ast.Draw, shape: Shape) -> None:
    seen: dict[str, Span] = {}
    for field in item.fields:
        if field.name not in shape.fields:
            raise Mistake(e08_drawings.unknown_field(item.shape, field.name, shape.fields, field.span))
        if field.name in seen:
            raise Mistake(e08_drawings.second_field(field.name, field.span, seen[field.name]))
        seen[field.name] = field.span
    missing = [name for name in shape.needed if name not in seen]
    if missing:
        raise Mistake(e08_drawings.missing_fields(item.shape, missing, item.shape_span))


def _field(shape: str, field: ast.NewField, scope: Scope) -> ir.Expr | str:
    node, name = field.value, field.name
    if isinstance(node, ast.Literal) and isinstance(node.value, str):
        if name != "text":
            raise Mistake(e08_drawings.text_for_value(name, node.span))
        return node.value
    if name == "colour":
        return check_as(node, scope, COLOUR, "a colour")
    value = scope.check(node)
    if name == "text":
        return value
    if not operators.is_numeric(value.type):
        raise Mistake(e03_types.not_a_number(f"'{name}'", value.type, node.span))
    if shape == "cell" and not isinstance(value.type, Int):
        raise Mistake(e03_types.float_for_int(f"'{name}' of a cell", node.span))
    if name == "heading":
        require_plain(value, node.span, "a heading in radians")
    if shape == AREA and not isinstance(value, ir.Const):
        raise Mistake(e08_parts.not_constant(f"'{name}' of an area", node.span))
    return value


# Where things are --------------------------------------------------------------------------------


def _check_places(found: list[ir.Drawing], items: list[ast.Draw]) -> None:
    """Raise if there are two areas, something has no limits, or something is never in the picture."""
    areas = [d for d in found if d.shape == AREA]
    if len(areas) > 1:
        raise Mistake(e08_drawings.second_area(areas[1].span, areas[0].span))
    limits = {axis: _limits(areas[0], axis) for axis in "xy"} if areas else {}
    for drawing, item in zip(found, items, strict=True):
        spans = {f.name: f.value.span for f in item.fields}
        for name, e in drawing.fields.items():
            if name not in _AXES or not isinstance(e, ir.Expr) or drawing.shape == AREA:
                continue
            axis, ends = _AXES[name], _ends(e)
            if not limits and not all(map(math.isfinite, ends)):
                raise Mistake(e08_drawings.unknown_limits(drawing.name, axis, spans[name]))
            if (
                limits
                and drawing.shape != "line"
                and (ends[1] < limits[axis][0] or ends[0] > limits[axis][1])
            ):
                raise Mistake(e08_drawings.outside_area(drawing.name, axis, ends, limits[axis], spans[name]))


def _limits(area: ir.Drawing, axis: str) -> tuple[float, float]:
    low, high = (_ends(e)[0] for e in (area.fields[axis], area.fields[f"{axis}2"]) if isinstance(e, ir.Expr))
    if low >= high:
        raise Mistake(e08_drawings.empty_area(axis, low, high, area.span))
    return low, high


def _ends(e: ir.Expr) -> tuple[float, float]:
    assert isinstance(e.type, Int | Float)
    return operators.ends(e.type)
