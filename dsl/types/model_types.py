# SPDX-License-Identifier: Apache-2.0
"""The types of the language.

A value of a finite type is held as one integer: ranges as their value, ``bool`` as 0 or 1, enums and
records as a code that counts from 0 (an enum's variants in order, a variant with an argument taking as
many codes as its argument has values; a record lexicographically, its first field the most
significant). Numeric types carry the interval that their values lie in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

from hypgen.dsl.types.units import PLAIN, Unit, shown

INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1


class Type:
    """Base of all types."""


@dataclass(frozen=True)
class Bool(Type):
    """Truth values."""

    def __str__(self) -> str:
        return "bool"


@dataclass(frozen=True)
class Int(Type):
    """Integers from ``low`` to ``high``, both included: a range type, or what an expression can reach."""

    low: int
    high: int

    def __str__(self) -> str:
        return "int" if (self.low, self.high) == (INT32_MIN, INT32_MAX) else f"{self.low} .. {self.high}"


@dataclass(frozen=True)
class Float(Type):
    """float32 numbers; the interval is what analysis knows of them. ``prob`` marks probabilities.

    ``unit`` counts while a model is checked; types that differ in it alone are equal.
    """

    low: float = -math.inf
    high: float = math.inf
    prob: bool = False
    unit: Unit | None = field(default=PLAIN, compare=False)

    def __str__(self) -> str:
        return "prob" if self.prob else f"float<{shown(self.unit)}>" if self.unit else "float"


@dataclass(frozen=True)
class Variant:
    """One case of an enum, with the finite type of its argument, or its glyph in grids, if it has one."""

    name: str
    argument: Type | None = None
    glyph: str | None = None


@dataclass(frozen=True)
class Enum(Type):
    """A named choice of variants."""

    name: str
    variants: tuple[Variant, ...]

    @cached_property
    def offsets(self) -> dict[str, int]:
        """Return each variant's first code."""
        result, code = {}, 0
        for variant in self.variants:
            result[variant.name] = code
            code += 1 if variant.argument is None else size_of(variant.argument)
        return result

    @cached_property
    def glyphs(self) -> dict[str, int]:
        """Return the codes of the variants that have a glyph, by glyph."""
        return {v.glyph: self.offsets[v.name] for v in self.variants if v.glyph is not None}

    def variant(self, name: str) -> Variant | None:
        """Return the variant called ``name``."""
        return next((v for v in self.variants if v.name == name), None)

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Record(Type):
    """A named product of finite fields, ordered lexicographically.

    One with a float among its fields exists in a file only: ``leaves`` takes what has its type apart.
    """

    name: str
    fields: tuple[tuple[str, Type], ...]

    def field_type(self, name: str) -> Type | None:
        """Return the type of field ``name``."""
        return next((t for n, t in self.fields if n == name), None)

    def stride(self, name: str) -> int:
        """Return by how much the code grows when field ``name`` grows by one."""
        names = [n for n, _ in self.fields]
        return math.prod(size_of(t) for _, t in self.fields[names.index(name) + 1 :])

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Array(Type):
    """Values of ``element`` indexed by finite types, row-major."""

    element: Type
    indices: tuple[Type, ...]

    def __str__(self) -> str:
        return f"{self.element}[{', '.join(map(str, self.indices))}]"


BOOL = Bool()
INT = Int(INT32_MIN, INT32_MAX)
FLOAT = Float()
PROB = Float(0.0, 1.0, prob=True)


def is_finite(t: Type) -> bool:
    """Return whether ``t`` has finitely many values that index, bind and branch (``int`` itself does not)."""
    if isinstance(t, Record):
        return all(is_finite(f) for _, f in t.fields)
    return isinstance(t, Bool | Enum) or (isinstance(t, Int) and t != INT)


def size_of(t: Type) -> int:
    """Return the number of values of a finite type."""
    match t:
        case Bool():
            return 2
        case Int(low, high):
            return high - low + 1
        case Enum(_, variants):
            return sum(1 if v.argument is None else size_of(v.argument) for v in variants)
        case Record(_, fields):
            return math.prod(size_of(f) for _, f in fields)
        case Array(element, indices):
            return int(size_of(element) ** math.prod(size_of(i) for i in indices))
    raise TypeError(f"{t} is not finite")


def low_of(t: Type) -> int:
    """Return the smallest value of a finite type: what to subtract for an index from 0."""
    return t.low if isinstance(t, Int) else 0


def digits_of(t: Type) -> int:
    """Return how many values a digit of an observation key takes; a float's bits are one digit."""
    return 1 << 32 if isinstance(t, Float) else size_of(t)


def length_of(indices: tuple[Type, ...]) -> int:
    """Return the number of entries of an array with these index types (1 for a scalar)."""
    return math.prod(size_of(i) for i in indices)


def flat_indices(indices: tuple[Type, ...]) -> tuple[Type, ...]:
    """Return index types with records replaced by their fields; the entries keep their order."""
    result: tuple[Type, ...] = ()
    for index in indices:
        fields = tuple(t for _, t in index.fields) if isinstance(index, Record) else None
        result += (index,) if fields is None else flat_indices(fields)
    return result
