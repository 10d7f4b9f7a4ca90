# SPDX-License-Identifier: Apache-2.0
"""Building typed expressions: intervals are propagated and constants folded as nodes are made.

Operands are already of agreeing kinds unless a function says that it promotes. Nothing here knows of source
positions: a result whose interval leaves int32 is for the caller to refuse.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

from hypgen.dsl import ir
from hypgen.dsl.ir import evaluate
from hypgen.dsl.ir.walk import Node, children
from hypgen.dsl.types import (
    BOOL,
    FLOAT,
    INT32_MAX,
    INT32_MIN,
    Bool,
    Enum,
    Float,
    Int,
    Record,
    Type,
    intervals,
    is_finite,
    units,
)
from hypgen.dsl.types.units import Unit

_EXACT = {"add": operator.add, "sub": operator.sub, "mul": operator.mul, "div": operator.truediv}
_MOST_BITS = 4096  # of an exact number's denominator

TRUE, FALSE = ir.Const(BOOL, True), ir.Const(BOOL, False)


def boolean(value: bool) -> ir.Const:
    """Return a constant truth value."""
    return TRUE if value else FALSE


def integer(value: int) -> ir.Const:
    """Return a constant int."""
    return ir.Const(Int(value, value), value)


def real(value: float, unit: Unit | None = None, exact: Fraction | None = None) -> ir.Const:
    """Return a constant float, rounded to float32; without a unit it takes on any.

    ``exact`` is the number before it was rounded, where that is known.
    """
    value = intervals.float32(value)
    kept = None if exact is None or exact == value else exact
    return ir.Const(Float(value, value, unit=unit), value, exact=kept)


def literal(value: bool | int | float, exact: Fraction | None = None) -> ir.Const:
    """Return the constant for a Python value."""
    if isinstance(value, bool):
        return boolean(value)
    return integer(value) if isinstance(value, int) else real(value, exact=exact)


def is_true(e: ir.Expr) -> bool:
    """Return whether ``e`` is the constant true."""
    return isinstance(e, ir.Const) and e.value is True


def is_false(e: ir.Expr) -> bool:
    """Return whether ``e`` is the constant false."""
    return isinstance(e, ir.Const) and e.value is False


def is_numeric(t: Type) -> bool:
    """Return whether ``t`` is an int or float type."""
    return isinstance(t, Int | Float)


def ends(t: Type) -> tuple[float, float]:
    """Return the interval of a numeric type; ints where the type is Int."""
    assert isinstance(t, Int | Float)
    return t.low, t.high


def unit_of(e: ir.Expr) -> Unit | None:
    """Return a number's unit: none for a literal, which adapts, and that of plain numbers for an int."""
    if isinstance(e.type, Float):
        return e.type.unit
    return None if isinstance(e, ir.Const) else units.PLAIN


def measured(e: ir.Expr, unit: Unit | None) -> ir.Expr:
    """Return ``e`` in a unit; an int has none."""
    if not isinstance(e.type, Float) or e.type.unit == unit:
        return e
    return replace(e, type=replace(e.type, unit=unit))


def _int_ends(t: Type) -> tuple[int, int]:
    assert isinstance(t, Int)
    return t.low, t.high


def _int(found: tuple[float, float]) -> Int:
    return Int(int(found[0]), int(found[1]))


def _float(found: tuple[float, float], unit: Unit | None = units.PLAIN) -> Float:
    return Float(*intervals.rounded(found), unit=unit)


def numeric(kind: Type, found: tuple[float, float]) -> Int | Float:
    """Return the numeric type of the same kind and unit as ``kind`` with this interval."""
    return _float(found, kind.unit) if isinstance(kind, Float) else _int(found)


def join(a: Type, b: Type) -> Type | None:
    """Return the least type with the values of both, or None where they differ in kind or unit."""
    if isinstance(a, Int) and isinstance(b, Int):
        return Int(min(a.low, b.low), max(a.high, b.high))
    if isinstance(a, Float) and isinstance(b, Float):
        if not units.agree(a.unit, b.unit):
            return None
        prob, unit = a.prob and b.prob, units.merged(a.unit, b.unit)
        return Float(min(a.low, b.low), max(a.high, b.high), prob, unit)
    return a if a == b else None


def to_float(e: ir.Expr) -> ir.Expr:
    """Return a number as a float."""
    if isinstance(e.type, Float):
        return e
    if isinstance(e, ir.Const):
        return real(float(e.value))
    return ir.ToFloat(_float(ends(e.type)), e)


def promote(a: ir.Expr, b: ir.Expr) -> tuple[ir.Expr, ir.Expr]:
    """Return two numbers as one kind: floats if either is."""
    if isinstance(a.type, Float) or isinstance(b.type, Float):
        return to_float(a), to_float(b)
    return a, b


def negate(e: ir.Expr) -> ir.Expr:
    """Return -e of a number."""
    low, high = ends(e.type)
    if isinstance(e, ir.Const):
        exact = None if e.exact is None else -e.exact
        return measured(literal(evaluate.OPERATORS["neg"](e.value), exact), unit_of(e))
    return ir.Unary(numeric(e.type, (-high, -low)), "neg", e)


def invert(e: ir.Expr) -> ir.Expr:
    """Return ``not e``."""
    return boolean(not e.value) if isinstance(e, ir.Const) else ir.Unary(BOOL, "not", e)


def both(a: ir.Expr, b: ir.Expr) -> ir.Expr:
    """Return ``a and b``."""
    if is_false(a) or is_true(b):
        return a
    if is_true(a) or is_false(b):
        return b
    return ir.Binary(BOOL, "and", a, b)


def either(a: ir.Expr, b: ir.Expr) -> ir.Expr:
    """Return ``a or b``."""
    if is_true(a) or is_false(b):
        return a
    if is_false(a) or is_true(b):
        return b
    return ir.Binary(BOOL, "or", a, b)


def folded(op: str, unit: Unit | None, *operands: ir.Expr) -> ir.Const | None:
    """Return an operator on constants as a float; None where an operand varies or there is no value."""
    values = _constants(operands)
    result = None if values is None else evaluate.value_of(op, FLOAT, *values)
    return None if result is None else real(result, unit, _exactly(op, operands))


def _exactly(op: str, operands: tuple[ir.Expr, ...]) -> Fraction | None:
    """Return the number that an operator gives on constants before any is rounded; None for no fraction."""
    if op not in _EXACT:
        return None
    numbers = [Fraction(e.value) if e.exact is None else e.exact for e in operands if isinstance(e, ir.Const)]
    if op == "div" and not numbers[1]:
        return None
    found: Fraction = _EXACT[op](*numbers)
    return found if found.denominator.bit_length() < _MOST_BITS else None


def _constants(operands: tuple[Node, ...]) -> list[evaluate.Value] | None:
    values = [e.value for e in operands if isinstance(e, ir.Const)]
    return values if len(values) == len(operands) else None


def arithmetic(op: str, a: ir.Expr, b: ir.Expr) -> ir.Expr:
    """Return ``add sub mul div min max floordiv mod`` of two numbers, promoted."""
    unit = _unit_of_result(op, unit_of(a), unit_of(b))
    a, b = (to_float(a), to_float(b)) if op == "div" else promote(a, b)
    if isinstance(a.type, Int):
        if isinstance(a, ir.Const) and isinstance(b, ir.Const):
            return integer(evaluate.OPERATORS[op](a.value, b.value))
        return ir.Binary(_int(_int_interval(op, _int_ends(a.type), _int_ends(b.type))), op, a, b)
    found = _float(_plain_interval(op, ends(a.type), ends(b.type)), unit)
    return folded(op, unit, a, b) or ir.Binary(found, op, a, b)


def _unit_of_result(op: str, a: Unit | None, b: Unit | None) -> Unit | None:
    return units.product(a, b, -1 if op == "div" else 1) if op in ("mul", "div") else units.merged(a, b)


def _plain_interval(op: str, a: intervals.Ends, b: intervals.Ends) -> intervals.Ends:
    match op:
        case "add":
            return intervals.add(a, b)
        case "sub":
            return intervals.sub(a, b)
        case "mul":
            return intervals.mul(a, b)
        case "div":
            return intervals.div(a, b)
        case "min":
            return min(a[0], b[0]), min(a[1], b[1])
    return max(a[0], b[0]), max(a[1], b[1])


def _int_interval(op: str, a: tuple[int, int], b: tuple[int, int]) -> tuple[float, float]:
    if op == "floordiv":
        return intervals.floordiv(a, b)
    if op == "mod":
        exact = a[0] == a[1] and b[0] == b[1] != 0
        return (a[0] % b[0], a[0] % b[0]) if exact else intervals.mod(a, b)
    return _plain_interval(op, a, b)


def compare(op: str, a: ir.Expr, b: ir.Expr) -> ir.Expr:
    """Return a comparison; ints whose intervals decide it fold to a constant."""
    if isinstance(a, ir.Const) and isinstance(b, ir.Const):
        return boolean(evaluate.COMPARISONS[op](a.value, b.value))
    if isinstance(a.type, Int) and isinstance(b.type, Int):
        x, y = a.type, b.type
        decided = {
            "lt": (x.high < y.low, x.low >= y.high),
            "le": (x.high <= y.low, x.low > y.high),
            "gt": (x.low > y.high, x.high <= y.low),
            "ge": (x.low >= y.high, x.high < y.low),
            "eq": (False, x.high < y.low or y.high < x.low),
            "ne": (x.high < y.low or y.high < x.low, False),
        }[op]
        if any(decided):
            return boolean(decided[0])
    return ir.Binary(BOOL, op, a, b)


def power(a: ir.Expr, b: ir.Expr) -> ir.Expr:
    """Return a ** b of floats."""
    unit = units.merged(unit_of(a), unit_of(b))
    if unit_of(a) and isinstance(b, ir.Const):
        unit = units.power(unit_of(a), int(b.value))
    a, b = to_float(a), to_float(b)
    found = intervals.power(ends(a.type), ends(b.type))
    return folded("pow", unit, a, b) or ir.Binary(_float(found, unit), "pow", a, b)


def hypotenuse(a: ir.Expr, b: ir.Expr) -> ir.Expr:
    """Return hypot(a, b) of floats."""
    unit = units.merged(unit_of(a), unit_of(b))
    a, b = to_float(a), to_float(b)
    found = intervals.hypotenuse(ends(a.type), ends(b.type))
    return folded("hypot", unit, a, b) or ir.Binary(_float(found, unit), "hypot", a, b)


def absolute(e: ir.Expr) -> ir.Expr:
    """Return |e|."""
    if isinstance(e, ir.Const):
        return measured(literal(evaluate.OPERATORS["abs"](e.value)), unit_of(e))
    return ir.Unary(numeric(e.type, intervals.absolute(ends(e.type))), "abs", e)


def sign(e: ir.Expr) -> ir.Expr:
    """Return -1, 0 or 1, of the operand's kind."""
    low, high = map(evaluate.OPERATORS["sign"], ends(e.type))
    if isinstance(e, ir.Const):
        return integer(low) if isinstance(e.type, Int) else real(low)
    return ir.Unary(_int((low, high)) if isinstance(e.type, Int) else _float((low, high)), "sign", e)


def rising(op: str, e: ir.Expr) -> ir.Expr:
    """Return ``sqrt exp log log2`` of a number as a float."""
    unit = units.root(unit_of(e)) if op == "sqrt" else unit_of(e)
    e = to_float(e)
    found = intervals.monotone(evaluate.OPERATORS[op], ends(e.type))
    return folded(op, unit, e) or ir.Unary(_float(found, unit), op, e)


def normal_cdf(e: ir.Expr) -> ir.Expr:
    """Return how likely a standard normal number is below a float."""
    return folded("normal_cdf", units.PLAIN, e) or ir.Unary(Float(0.0, 1.0), "normal_cdf", e)


def to_int(op: str, e: ir.Expr) -> ir.Expr:
    """Return ``floor ceil round`` of a number; an int is its own."""
    if isinstance(e.type, Int):
        return e
    low, high = (_saturated(evaluate.ROUNDINGS[op], x) for x in ends(e.type))
    return integer(low) if isinstance(e, ir.Const) else ir.Unary(Int(low, high), op, e)


def _saturated(function: Callable[[float], int], x: float) -> int:
    if math.isinf(x):
        return INT32_MAX if x > 0 else INT32_MIN
    return min(max(function(x), INT32_MIN), INT32_MAX)


def clamp(e: ir.Expr, low: float, high: float, node: type[ir.Clamp] = ir.Clamp) -> ir.Expr:
    """Return a number forced into [low, high], which are of its kind; itself where it lies there."""
    x, y = ends(e.type)
    if low <= x and y <= high:
        return e
    found = (min(max(x, low), high), min(max(y, low), high))
    if found[0] == found[1] and isinstance(e.type, Int):
        return integer(int(found[0]))
    if isinstance(e, ir.Const):
        return measured(literal(type(e.value)(found[0])), unit_of(e))
    kind = numeric(e.type, found)
    return node(kind, e, int(low), int(high)) if isinstance(kind, Int) else node(kind, e, low, high)


def choose(condition: ir.Expr, then: ir.Expr, otherwise: ir.Expr) -> ir.Expr:
    """Return ``if condition then .. else ..`` of branches of one kind."""
    if isinstance(condition, ir.Const):
        return then if condition.value else otherwise
    joined = join(then.type, otherwise.type)
    assert joined is not None
    if isinstance(then, ir.Const) and then == otherwise and not isinstance(joined, Float):
        return then
    return ir.If(joined, condition, then, otherwise)


def is_variant(enum: Enum, name: str, e: ir.Expr) -> ir.Expr:
    """Return whether ``e`` is the variant, of any argument."""
    return _computed(ir.IsVariant(BOOL, enum, name, e))


def variant_argument(enum: Enum, name: str, e: ir.Expr) -> ir.Expr:
    """Return the argument of the variant that ``e`` is."""
    variant = enum.variant(name)
    assert variant is not None and variant.argument is not None
    argument = ir.VariantArgument(variant.argument, enum, name, e)
    return _computed(argument) if is_true(is_variant(enum, name, e)) else argument


def make_variant(enum: Enum, name: str, argument: ir.Expr) -> ir.Expr:
    """Return a variant with its argument."""
    return _computed(ir.MakeVariant(enum, enum, name, argument))


def field(record: Record, name: str, e: ir.Expr) -> ir.Expr:
    """Return a record's field."""
    found = record.field_type(name)
    assert found is not None
    if isinstance(e, ir.MakeRecord):
        return e.values[[n for n, _ in record.fields].index(name)]
    return _computed(ir.FieldRead(found, record, name, e))


def make_record(record: Record, values: tuple[ir.Expr, ...]) -> ir.Expr:
    """Return a record of its fields' values."""
    e = ir.MakeRecord(record, record, values)
    return _computed(e) if is_finite(record) else e


def _computed(e: ir.Expr) -> ir.Expr:
    """Return ``e``, of a finite type, or its value if its operands are constants."""
    values = _constants(tuple(children(e)))
    operation = None if values is None else evaluate.of_node(e)
    return e if operation is None else constant(e.type, operation(*values or ()))


def constant(t: Type, value: evaluate.Value) -> ir.Const:
    """Return a value of a finite type as a constant."""
    return literal(value) if isinstance(t, Int | Bool) else ir.Const(t, value)


def to_index(t: Type, value: bool | int | float) -> int:
    """Return a finite type's value counted from 0."""
    return int(value) - (t.low if isinstance(t, Int) else 0)


def from_index(t: Type, index: int) -> ir.Const:
    """Return the value of a finite type with this number, counted from 0."""
    return constant(t, evaluate.value_at(t, index))


def retyped(e: ir.Expr, t: Type) -> ir.Expr:
    """Return ``e`` with a narrower type, or an int code under another name."""
    return e if e.type == t or isinstance(e, ir.Const) else replace(e, type=t)
