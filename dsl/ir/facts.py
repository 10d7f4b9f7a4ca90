# SPDX-License-Identifier: Apache-2.0
"""Facts that conditions show of numbers: intervals of reads, of expressions and of differences."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.walk import shape, walk
from hypgen.dsl.types import Float, Int, intervals

Ends = tuple[float, float]
Facts = Mapping[Hashable, Ends]
Body = Callable[[ir.Expr], ir.Expr | None]
"""What a call or the read of a let stands for, None for anything else."""

_OPPOSITE = {"lt": "ge", "ge": "lt", "le": "gt", "gt": "le", "eq": "ne", "ne": "eq"}
_MIRRORED = {"lt": "gt", "gt": "lt", "le": "ge", "ge": "le", "eq": "eq", "ne": "ne"}
_READS = (
    ir.Local,
    ir.FieldRead,
    ir.StateRead,
    ir.LetRead,
    ir.ParamRead,
    ir.TableRead,
    ir.ActionRead,
    ir.MemoryRead,
)
# Facts are kept of what consists of these alone.
_NOTED = (*_READS, ir.Const, ir.Call, ir.ToFloat, ir.Unary, ir.Binary, ir.Clamp, ir.VariantArgument)
_MOST_CLAMPS = 4


def learned(condition: ir.Expr, holds: bool, facts: Facts, body: Body) -> Facts:
    """Return ``facts`` and what follows from ``condition`` being true, or false."""
    found = dict(facts)
    _learn(condition, holds, found, body)
    return found


def narrowed(e: ir.Expr, facts: Facts) -> ir.Expr:
    """Return ``e`` with what is known of it.

    A read takes a narrower type. A larger int expression is clamped, which changes nothing where the
    condition holds, and keeps indexes in range elsewhere: tables are filled for all values of their inputs.
    """
    for _ in range(_MOST_CLAMPS):
        known = facts.get(key(e)) if isinstance(e.type, Int | Float) else None
        if known is None:
            return e
        least, most = operators.ends(e.type)
        low, high = max(known[0], least), min(known[1], most)
        if low > high or (low, high) == (least, most):
            return e
        if isinstance(e, _READS):
            return replace(e, type=operators.numeric(e.type, (low, high)))
        if isinstance(e.type, Float):
            return e
        e = operators.clamp(e, low, high)
    return e


def key(e: ir.Expr) -> Hashable:
    """Return what identifies an expression whatever is known of its type; None if nothing is noted of it."""
    return shape(e) if all(isinstance(inner, _NOTED) for inner in walk(e)) else None


def _learn(condition: ir.Expr, holds: bool, facts: dict[Hashable, Ends], body: Body) -> None:
    match condition:
        case ir.Unary(_, "not", operand):
            _learn(operand, not holds, facts, body)
        case ir.Binary(_, "and" | "or" as op, left, right) if holds == (op == "and"):
            _learn(left, holds, facts, body)
            _learn(right, holds, facts, body)
        case ir.Binary(_, "and" | "or", left, right):
            _learn_either(left, right, holds, facts, body)
        case ir.Binary(_, op, left, right) if op in _OPPOSITE and isinstance(left.type, Int | Float):
            shown = op if holds else _OPPOSITE[op]
            _limit(left, shown, right, facts)
            _limit(right, _MIRRORED[shown], left, facts)
            if isinstance(left.type, Int):
                _compare(left, shown, right, facts)
                _compare(right, _MIRRORED[shown], left, facts)
        case ir.Call() | ir.LetRead():
            meaning = body(condition)
            if meaning is not None:
                _learn(meaning, holds, facts, body)


def _learn_either(
    left: ir.Expr, right: ir.Expr, holds: bool, facts: dict[Hashable, Ends], body: Body
) -> None:
    """Learn what two conditions have in common, one of which is known to hold."""
    first, second = learned(left, holds, facts, body), learned(right, holds, facts, body)
    for name in first.keys() & second.keys():
        a, b = first[name], second[name]
        facts[name] = (min(a[0], b[0]), max(a[1], b[1]))


def _limit(e: ir.Expr, op: str, other: ir.Expr, facts: dict[Hashable, Ends]) -> None:
    """Note what ``e op other`` says of ``e``, given the interval of ``other``."""
    if isinstance(e, ir.Const):
        return
    _note(e, op, operators.ends(other.type), facts)
    match e:
        case ir.Binary(Int(), "add" | "sub" as sign, part, ir.Const(_, shift)) if isinstance(part.type, Int):
            moved = operators.arithmetic(
                "sub" if sign == "add" else "add", other, operators.integer(int(shift))
            )
            _limit(part, op, moved, facts)


def _compare(e: ir.Expr, op: str, other: ir.Expr, facts: dict[Hashable, Ends]) -> None:
    """Note what ``e op other`` says of ``e - other``."""
    if not isinstance(e, ir.Const) and not isinstance(other, ir.Const):
        _note(operators.arithmetic("sub", e, other), op, (0, 0), facts)


def _note(e: ir.Expr, op: str, other: Ends, facts: dict[Hashable, Ends]) -> None:
    name = key(e)
    if name is None:
        return
    whole = isinstance(e.type, Int)
    low, high = facts.get(name, operators.ends(e.type))
    least, most = other
    match op:
        case "lt":
            high = min(high, most - 1 if whole else _next(most, -1))
        case "le":
            high = min(high, most)
        case "gt":
            low = max(low, least + 1 if whole else _next(least, 1))
        case "ge":
            low = max(low, least)
        case "eq":
            low, high = max(low, least), min(high, most)
        case "ne" if whole and least == most:
            low, high = low + (low == least), high - (high == least)
    if low <= high:
        facts[name] = (low, high)


def _next(value: float, direction: int) -> float:
    """Return the float32 next to ``value``, above or below."""
    value = intervals.float32(value)
    if math.isinf(value):
        return value
    if value == 0:
        return direction * 2.0**-149
    (bits,) = struct.unpack("<i", struct.pack("<f", value))
    moved = bits + direction if value > 0 else bits - direction
    return float(struct.unpack("<f", struct.pack("<i", moved))[0])
