# SPDX-License-Identifier: Apache-2.0
"""What expressions give on constants: one table of operators for all that compute while a model is compiled.

Values are Python's: bool, int (or a code), and floats that float32 holds. A float operator computes in double
and rounds once. Where a result is not finite, or no number, there is no value: folding leaves the operator to
be evaluated when the model runs.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable
from typing import Any, TypeAlias

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import children
from hypgen.dsl.types import Bool, Enum, Float, Int, Type, low_of, size_of

Value: TypeAlias = bool | int | float
Operation: TypeAlias = Callable[..., Any]  # raises ArithmeticError or ValueError where there is no value
Known: TypeAlias = Callable[[ir.Expr], Value | None]  # what a read gives, where it is known

_FLOAT32 = struct.Struct("<f")


def single(value: float) -> float:
    """Return ``value`` as float32; raises ``ArithmeticError`` where that is not finite."""
    result: float = _FLOAT32.unpack(_FLOAT32.pack(value))[0]
    if not math.isfinite(result):
        raise ArithmeticError
    return result


def _smaller(a: Any, b: Any) -> Any:
    return b if b < a else a


def _larger(a: Any, b: Any) -> Any:
    return b if a < b else a


def _sign(x: Any) -> int:
    return int(x > 0) - int(x < 0)


def _floordiv(a: int, b: int) -> int:
    return a // b if b else 0


def _mod(a: int, b: int) -> int:
    return a % b if b else 0


COMPARISONS: dict[str, Operation] = {
    "eq": operator.eq,
    "ne": operator.ne,
    "lt": operator.lt,
    "le": operator.le,
    "gt": operator.gt,
    "ge": operator.ge,
}
ROUNDINGS: dict[str, Operation] = {"floor": math.floor, "ceil": math.ceil, "round": round}
# Before rounding to float32. ``and`` and ``or`` are not here: they do not need both operands.
OPERATORS: dict[str, Operation] = {
    **COMPARISONS,
    **ROUNDINGS,
    "neg": operator.neg,
    "not": operator.not_,
    "abs": abs,
    "sign": _sign,
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "floordiv": _floordiv,
    "mod": _mod,
    "min": _smaller,
    "max": _larger,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "log2": math.log2,
    "pow": math.pow,
    "hypot": math.hypot,
    "normal_cdf": lambda x: 0.5 * math.erfc(-x / math.sqrt(2.0)),
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan2": math.atan2,
}
# What Python computes to another last bit than the runtime does.
INEXACT = frozenset(
    {"exp", "log", "log2", "pow", "hypot", "sin", "cos", "tan", "asin", "acos", "atan2", "normal_cdf"}
)
_UNROUNDED = frozenset({"neg", "abs", "min", "max"})  # of floats they give a float32 as it is


def of_operator(op: str, type_: Type) -> Operation:
    """Return what computes ``Unary`` or ``Binary`` nodes of this operator and type."""
    function = OPERATORS[op]
    if op in ROUNDINGS:
        assert isinstance(type_, Int)
        low, high = type_.low, type_.high
        return lambda x: min(max(function(x), low), high)
    if not isinstance(type_, Float) or op in _UNROUNDED:
        return function
    return lambda *operands: single(function(*operands))


def value_of(op: str, type_: Type, *operands: Value) -> Value | None:
    """Return the value of an operator on constants, None where there is none."""
    return _given(of_operator(op, type_), operands)


def value_at(t: Type, position: int) -> bool | int:
    """Return the value of a finite type with this number, counted from 0."""
    return bool(position) if isinstance(t, Bool) else position + low_of(t)


def of_node(e: ir.Expr) -> Operation | None:
    """Return what computes ``e`` from the values of its children in order; None where that is not all.

    Choices, quantifiers, lets and reads need more than values.
    """
    match e:
        case ir.Unary(type_, op) | ir.Binary(type_, op) if op in OPERATORS:
            return of_operator(op, type_)
        case ir.ToFloat():
            return single
        case ir.Clamp(_, _, low, high):
            return lambda x: min(max(x, low), high)
        case ir.IsVariant(_, enum, variant):
            first, end = _codes(enum, variant)
            return lambda code: first <= code < end
        case ir.VariantArgument(_, enum, variant):
            kind, first = _argument(enum, variant), enum.offsets[variant]
            return lambda code: value_at(kind, code - first)
        case ir.MakeVariant(_, enum, variant):
            shift = enum.offsets[variant] - low_of(_argument(enum, variant))
            return lambda argument: argument + shift
        case ir.FieldRead(_, record, name):
            t, stride = record.field_type(name), record.stride(name)
            assert t is not None
            field, size = t, size_of(t)
            return lambda code: value_at(field, code // stride % size)
        case ir.MakeRecord(_, record):
            places = [(low_of(t), record.stride(name)) for name, t in record.fields]
            return lambda *values: sum((v - low) * s for v, (low, s) in zip(values, places, strict=True))
    return None


def _codes(enum: Enum, variant: str) -> tuple[int, int]:
    """Return the first code of a variant, and the one after its last."""
    found = enum.variant(variant)
    assert found is not None
    first = enum.offsets[variant]
    return first, first + (1 if found.argument is None else size_of(found.argument))


def _argument(enum: Enum, variant: str) -> Type:
    found = enum.variant(variant)
    assert found is not None and found.argument is not None
    return found.argument


def decided(e: ir.Expr, known: Known) -> Value | None:
    """Return the value of ``e`` to the runtime's last bit, None where what is known does not decide it.

    ``known`` gives the values of locals, state and actions as far as they are known. ``e`` has no calls,
    lets and quantifiers: ``codegen`` has written them out.
    """
    match e:
        case ir.Const(value=value):
            return value
        case ir.Local() | ir.StateRead() | ir.ActionRead():
            return known(e)
        case ir.Binary(op="and" | "or" as op, left=left, right=right):
            parts = (decided(left, known), decided(right, known))
            decides = op == "or"
            return decides if decides in parts else None if None in parts else not decides
        case ir.If(condition=condition, then=then, otherwise=otherwise):
            holds, a, b = (decided(part, known) for part in (condition, then, otherwise))
            if holds is None:
                return a if a == b else None
            return a if holds else b
        case ir.Unary(op=op) | ir.Binary(op=op) if op in INEXACT:
            return None
    operation = of_node(e)
    if operation is None:
        return None
    values = [decided(child, known) for child in children(e) if isinstance(child, ir.Expr)]
    operands = [value for value in values if value is not None]
    return None if len(operands) < len(values) else _given(operation, operands)


def _given(operation: Operation, operands: Any) -> Value | None:
    try:
        result: Value = operation(*operands)
    except (ArithmeticError, ValueError):
        return None
    return result
