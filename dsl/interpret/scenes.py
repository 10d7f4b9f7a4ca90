# SPDX-License-Identifier: Apache-2.0
"""Scenes: the shapes that a model's ``draw`` declarations make of states, as plain data.

A shape is a dict: ``shape`` and ``name`` of its declaration, and its fields by name. Colours are names, and a
heading is in radians. A shape of a belief has ``p``, its probability. The world's y grows upwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame, State, dtype_of, from_position
from hypgen.dsl.interpret.value_text import value_text
from hypgen.dsl.ir.operators import ends
from hypgen.dsl.types import Bool, Enum, Float, Int, Type, length_of, low_of, size_of
from hypgen.dsl.types.palette import COLOUR

MOST_SHAPES = 400
"""How many shapes a belief is cut to."""

MOST_CELLS = 400
"""How many cells wide and tall a picture has; a larger one is a plane."""

Shape = dict[str, Any]
_DEFAULTS = {"label": "black", "gauge": "blue"}
_DIGITS = 5  # of a position in the data
_AREA = "area"


class Scenes:
    """Makes scenes of a model with some params, entries row-major or nested, enums as codes or texts."""

    def __init__(self, model: ir.Model, params: Mapping[str, Any] | None = None) -> None:
        self.model, params = model, params or {}
        self._texts: dict[Type, dict[str, int]] = {}
        given: dict[str, Any] = {
            p.name: self._codes(params[p.name], p.type) for p in model.params if p.name in params
        }
        self._evaluator = Evaluator(model, given)
        shapes = [d for d in model.drawings if d.shape != _AREA]
        hidden = {v.name for v in model.variables if not v.visible}
        self._fixed = [d for d in shapes if not d.reads]
        self._moving = [d for d in shapes if d.reads]
        self._hidden = [d for d in shapes if d.reads & hidden]

    def scene(self) -> dict[str, Any] | None:
        """Return what holds for a whole episode: ``extent`` and ``static``; None where nothing is drawn.

        ``extent`` has the ends of ``x`` and ``y``; with ``cells`` these are the first and last cell, each of
        size 1 around its number; without, what is drawn as a cell is a square in a plane. It is None where
        only gauges are drawn.
        """
        if not self._fixed and not self._moving:
            return None
        nothing = {
            v.name: np.zeros((1, *map(size_of, v.indices)), dtype_of(v.type)) for v in self.model.variables
        }
        return {"extent": self._extent(), "static": self._plain(self._fixed, nothing)}

    def truth(self, state: Mapping[str, Any], *, hidden: bool = True) -> list[Shape]:
        """Return the shapes of a state that are not static; without ``hidden`` only those that are seen.

        ``state`` has the entries of each variable, row-major: numbers, and codes or texts of enums and
        records.
        """
        shown = [d for d in self._moving if hidden or d not in self._hidden]
        return self._plain(shown, self._states(state, {}, 1))

    def belief(
        self,
        state: Mapping[str, Any],
        sampled: Mapping[str, Sequence[Any] | Array],
        weights: Sequence[float] | None = None,
    ) -> dict[str, Any]:
        """Return the shapes of sampled hidden variables: ``belief``, ``belief_shown`` and ``belief_total``.

        ``state`` has the visible variables and ``sampled`` hidden ones, a list by sample; what reads others
        is left out. Equal shapes are one, with the sum of their probabilities; the likeliest
        ``MOST_SHAPES`` are kept, in the order in which they cover each other.
        """
        count = len(next(iter(sampled.values()), ()))
        visible = {v.name for v in self.model.variables if v.visible}
        known = [d for d in self._hidden if d.reads <= visible | set(sampled)]
        found: list[tuple[float, int, int, Shape]] = []
        if count and known:
            chance = (
                np.full(count, 1 / count) if weights is None else np.asarray(weights, float) / sum(weights)
            )
            states = self._states(state, sampled, count)
            for number, drawing in enumerate(known):
                for mass, first, shape in self._merged(drawing, states, chance):
                    found.append((-mass, first, number, shape | {"p": _short(mass)}))
        found.sort(key=lambda entry: entry[:3])
        kept = sorted(found[:MOST_SHAPES], key=lambda entry: (entry[2], -entry[0]))
        shapes = [entry[3] for entry in kept]
        return {"belief": shapes, "belief_shown": len(shapes), "belief_total": len(found)}

    # States --------------------------------------------------------------------------------------

    def _states(self, state: Mapping[str, Any], sampled: Mapping[str, Any], count: int) -> State:
        """Return states of the interpreter; variables that are not given are 0."""
        result: State = {}
        for v in self.model.variables:
            shape = (count, *map(size_of, v.indices))
            given = sampled[v.name] if v.name in sampled else state.get(v.name)
            if given is None:
                result[v.name] = np.zeros(shape, dtype_of(v.type))
                continue
            values = self._codes(given, v.type).reshape(-1, length_of(v.indices))
            result[v.name] = np.ascontiguousarray(
                np.broadcast_to(values, (count, values.shape[1])).reshape(shape)
            ).astype(dtype_of(v.type))
        return result

    def _codes(self, given: Any, t: Type) -> Array:
        if isinstance(t, Float):
            return np.asarray(given, np.float32)  # None is no number
        values = np.asarray(given)
        if values.dtype.kind not in "UO":
            return values
        codes = self._texts.setdefault(
            t, {value_text(c + low_of(t), t): c + low_of(t) for c in range(size_of(t))}
        )
        return np.asarray([codes.get(x, x) if isinstance(x, str) else x for x in values.ravel()], np.int64)

    # Shapes --------------------------------------------------------------------------------------

    def _plain(self, drawings: Sequence[ir.Drawing], state: State) -> list[Shape]:
        """Return the shapes in one state, in order of declaration, then of members."""
        return [
            self._shape(drawing, row) for drawing in drawings for row in self._rows(drawing, state, 1)[0].T
        ]

    def _merged(
        self, drawing: ir.Drawing, states: State, chance: Array
    ) -> Iterator[tuple[float, int, Shape]]:
        """Yield each shape that differs, with its probability and the first sample that has it."""
        rows, lanes = self._rows(drawing, states, len(chance))
        if not lanes.size:
            return
        kinds, first, which = np.unique(rows, axis=1, return_index=True, return_inverse=True)
        mass = np.bincount(which.ravel(), weights=chance[lanes], minlength=kinds.shape[1])
        for number in range(kinds.shape[1]):
            yield (
                min(float(mass[number]), 1.0),
                int(lanes[first[number]]),
                self._shape(drawing, kinds[:, number]),
            )

    def _rows(self, drawing: ir.Drawing, state: State, count: int) -> tuple[Array, Array]:
        """Return the fields' values, one column for each shape, and the state that each shape is of."""
        members = length_of(tuple(b.type for b in drawing.binders))
        places = np.unravel_index(np.arange(members), tuple(size_of(b.type) for b in drawing.binders) or (1,))
        # Members are rows and states columns: what reads no state is computed once for each member.
        values = {
            b.name: from_position(p[:, np.newaxis], b.type)
            for b, p in zip(drawing.binders, places, strict=False)
        }
        frame = Frame(np.arange(count), state).bind(values)
        with np.errstate(all="ignore"):
            shown = np.broadcast_to(self._evaluator.value(drawing.where, frame), (members, count))
            fields = [
                np.broadcast_to(self._evaluator.value(e, frame), (members, count)).astype(np.float64)
                for e in drawing.fields.values()
                if not isinstance(e, str)
            ]
        for field in fields:
            shown = shown & np.isfinite(field)
        member, lane = np.nonzero(shown)
        order = np.argsort(lane, kind="stable")
        member, lane = member[order], lane[order]
        table = np.stack([f[member, lane] for f in fields]) if fields else np.zeros((1, len(lane)))
        return table, lane

    def _shape(self, drawing: ir.Drawing, row: Array) -> Shape:
        shape: Shape = {"shape": drawing.shape, "name": drawing.name}
        if drawing.shape in _DEFAULTS:
            shape["colour"] = _DEFAULTS[drawing.shape]
        numbers = iter(row.tolist())
        for name, e in drawing.fields.items():
            shape[name] = e if isinstance(e, str) else _datum(next(numbers), name, e.type)
        return shape

    # The picture ---------------------------------------------------------------------------------

    def _extent(self) -> dict[str, Any] | None:
        cells = any(d.shape == "cell" for d in self.model.drawings)
        areas = [d for d in self.model.drawings if d.shape == _AREA]
        drawn = areas or list(self.model.drawings)
        extent: dict[str, Any] = {}
        for axis in "xy":
            found = [
                ends(e.type)
                for d in drawn
                for name, e in d.fields.items()
                if name in (axis, f"{axis}2") and isinstance(e, ir.Expr)
            ]
            if not found:
                return None
            extent[axis] = [min(low for low, _ in found), max(high for _, high in found)]
        # Fractions have no cells of their own, and a grid of a million squares is nothing to look at.
        extent["cells"] = cells and all(
            isinstance(end, int) and extent[axis][1] - extent[axis][0] < MOST_CELLS
            for axis in "xy"
            for end in extent[axis]
        )
        return extent


def _datum(value: float, name: str, t: Type) -> Any:
    """Return a field's value as data: text, a colour's name, an int, or a float of a few digits."""
    if name == "colour":
        return COLOUR.variants[int(value)].name
    if name == "text":
        return _text(value, t)
    return int(value) if isinstance(t, Int) else _short(value)


def _text(value: float, t: Type) -> str:
    """Return a value as a picture shows it: an enum's by its glyph if it has one."""
    if isinstance(t, Float):
        return f"{value:.3g}"
    if isinstance(t, Enum):
        variant = next((v for v in t.variants if v.glyph is not None and t.offsets[v.name] == value), None)
        if variant is not None and variant.glyph is not None:
            return variant.glyph
    return value_text(bool(value) if isinstance(t, Bool) else int(value), t)


def _short(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
