# SPDX-License-Identifier: Apache-2.0
"""Types, literals and codes in C++; knows nothing of models' structure."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache

from hypgen.codegen.layout.naming import Names
from hypgen.codegen.tree.expr import (
    FALSE,
    TRUE,
    Expr,
    Literal,
    Operand,
    call,
    cast,
    number,
    of,
    op,
    plus,
    shifted,
)
from hypgen.codegen.tree.statements import For, for_range
from hypgen.dsl.types import Bool, Enum, Float, Record, Type, is_finite, low_of, size_of


def scalar(type_: Type) -> str:
    """Return the C++ type that holds a value."""
    return "bool" if isinstance(type_, Bool) else "float" if isinstance(type_, Float) else "std::int32_t"


def stored(type_: Type) -> str:
    """Return the smallest C++ type for an entry of a table."""
    if not is_finite(type_) or isinstance(type_, Bool):
        return scalar(type_)
    low, high = low_of(type_), low_of(type_) + size_of(type_) - 1
    for bits in (8, 16):
        if low >= 0 and high < 2**bits:
            return f"std::uint{bits}_t"
        if low >= -(2 ** (bits - 1)) and high < 2 ** (bits - 1):
            return f"std::int{bits}_t"
    return "std::int32_t"


def float32(value: float) -> str:
    """Return a literal of exactly this float32: the shortest decimal that no rounding can miss."""
    if math.isnan(value):
        return "std::numeric_limits<float>::quiet_NaN()"
    if math.isinf(value):
        return ("-" if value < 0 else "") + "std::numeric_limits<float>::infinity()"
    if value == int(value) and abs(value) < 2**24:
        return f"{'-' if math.copysign(1, value) < 0 else ''}{abs(int(value))}.0f"
    return _shortest(value)


@lru_cache(maxsize=1 << 17)
def _shortest(value: float) -> str:
    bits = struct.unpack("<I", struct.pack("<f", value))[0]
    below = struct.unpack("<f", struct.pack("<I", bits - 1))[0]
    gap = abs(value - below)  # exact
    low, high = 1, 10  # a text with more digits is never farther off
    while low < high:
        digits = (low + high) // 2
        if _is_near(f"{value:.{digits}g}", value, gap):
            high = digits
        else:
            low = digits + 1
    if low == 10:
        return f"{value.hex()}f"
    text = f"{value:.{low}g}"
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def _is_near(text: str, value: float, gap: float) -> bool:
    """Return whether a number's text is off ``value`` by less than 9/20 of the ``gap`` to the next."""
    part = abs(float(text) - value) * 20 / (9 * gap)
    if abs(part - 1) > 1e-6:  # farther from the limit than rounding can reach
        return part < 1
    return abs(Fraction(text) - Fraction(value)) * 20 < 9 * Fraction(gap)


def literal(value: bool | int | float, type_: Type, names: Names) -> Expr:
    """Return a constant of the model as the model would say it: ``Act::check(3)``, ``Pos::make(1, 2)``."""
    match type_:
        case Bool():
            return TRUE if value else FALSE
        case Float():
            return Literal(float32(float(value)))
        case Enum(name, variants):
            code, members = int(value), names.members[name]
            for v in variants:
                size = 1 if v.argument is None else size_of(v.argument)
                if code < size:
                    constant = Literal(f"{names.types[name]}::{members[v.name]}")
                    if v.argument is None:
                        return constant
                    return call(constant, literal(code + low_of(v.argument), v.argument, names))
                code -= size
            raise AssertionError(f"{value} is no code of {name}")
        case Record(name, fields):
            parts = []
            for field, field_type in fields:
                code = int(value) // type_.stride(field) % size_of(field_type)
                parts.append(literal(code + low_of(field_type), field_type, names))
            return call(Literal(f"{names.types[name]}::{names.members[name]['make']}"), *parts)
    return number(int(value))


def code_of(value: Operand, type_: Type) -> Expr:
    """Return a finite value's code from 0."""
    if isinstance(type_, Bool):
        return cast("std::int32_t", value)
    return shifted(value, -low_of(type_))


def value_of(code: Operand, type_: Type) -> Expr:
    """Return the value with this code, the reverse of ``code_of``."""
    if isinstance(type_, Bool):
        return op(code, "!=", 0)
    return shifted(code, low_of(type_))


def row_major(codes: Sequence[Expr], types: Sequence[Type]) -> Expr:
    """Return the row-major position of an entry, whose indexes have these codes from 0."""
    result: Expr | None = None
    for code, type_ in zip(codes, types, strict=True):
        result = code if result is None else plus(result * size_of(type_), code)
    return number(0) if result is None else result


def from_int32(value: Operand, type_: Type, space: str = "") -> Expr:
    """Return the value that an int32 holds: as exported, and as a digit of a key with its low end added.

    ``space``: the namespace before the runtime's functions, where it takes one.
    """
    if isinstance(type_, Float):
        return call(f"{space}math::from_bits", cast("std::uint32_t", value))
    return op(value, "!=", 0) if isinstance(type_, Bool) else of(value)


def loop(type_: Type, variable: str) -> For:
    """Return a loop over a finite type's values (codes 0 and 1 for bool)."""
    low = low_of(type_)
    return for_range(variable, low, low + size_of(type_) - 1)
