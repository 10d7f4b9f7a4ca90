# SPDX-License-Identifier: Apache-2.0
"""C++ text of types, literals, codes and lines; knows nothing of models' structure."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache

from hypgen.codegen.layout.limits import LINE_LENGTH
from hypgen.codegen.layout.naming import Names
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


def integer(value: int) -> str:
    """Return an int32 literal."""
    return "(-2147483647 - 1)" if value == -(2**31) else str(value)


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


def literal(value: bool | int | float, type_: Type, names: Names) -> str:
    """Return a constant of the model as the model would say it: ``Act::check(3)``, ``Pos::make(1, 2)``."""
    match type_:
        case Bool():
            return "true" if value else "false"
        case Float():
            return float32(float(value))
        case Enum(name, variants):
            code, members = int(value), names.members[name]
            for v in variants:
                size = 1 if v.argument is None else size_of(v.argument)
                if code < size:
                    constant = f"{names.types[name]}::{members[v.name]}"
                    if v.argument is None:
                        return constant
                    return f"{constant}({literal(code + low_of(v.argument), v.argument, names)})"
                code -= size
            raise AssertionError(f"{value} is no code of {name}")
        case Record(name, fields):
            parts = []
            for field, field_type in fields:
                code = int(value) // type_.stride(field) % size_of(field_type)
                parts.append(literal(code + low_of(field_type), field_type, names))
            return f"{names.types[name]}::{names.members[name]['make']}({', '.join(parts)})"
    return integer(int(value))


def code_of(text: str, type_: Type) -> str:
    """Return a finite value's code from 0; ``text`` must bind at least as tightly as ``-``'s left side."""
    if isinstance(type_, Bool):
        return f"static_cast<std::int32_t>({text})"
    return shifted(text, -low_of(type_))


def value_of(code: str, type_: Type) -> str:
    """Return the value with this code, the reverse of ``code_of``."""
    if isinstance(type_, Bool):
        return f"({code}) != 0"
    return shifted(code, low_of(type_))


def from_int32(text: str, type_: Type) -> str:
    """Return the value that an int32 holds: as exported, and as a digit of a key with its low end added."""
    if isinstance(type_, Float):
        return f"math::from_bits(static_cast<std::uint32_t>({text}))"
    return f"{text} != 0" if isinstance(type_, Bool) else text


def shifted(text: str, amount: int) -> str:
    """Return ``text + amount``."""
    if amount == 0:
        return text
    return f"{text} + {amount}" if amount > 0 else f"{text} - {-amount}"


def loop(type_: Type, variable: str) -> str:
    """Return the head of a loop over a finite type's values (codes 0 and 1 for bool)."""
    low = low_of(type_)
    return f"for (std::int32_t {variable} = {low}; {variable} <= {low + size_of(type_) - 1}; ++{variable})"


_BREAK = re.compile(r", | (?:&&|\|\||=) | (?=[?:+] )")


class Code:
    """Lines under construction, with their indentation."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._depth = 0
        self._loose_braces = (0, 0)

    def add(self, line: str) -> None:
        """Append a line, broken where it is too long."""
        self.lines.extend(wrapped("  " * self._depth + line))

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Put what is added meanwhile into braces after ``head``; ``else`` goes on from the block before."""
        if head.startswith("else"):
            self.lines.pop()
            self._loose_braces = (0, 0)
            head = f"}} {head}"
        start = len(self.lines)
        self.add(f"{head} {{")
        self._depth += 1
        yield
        self._depth -= 1
        if head == "} else" and self.lines[-1].endswith("} else {"):
            self.lines.pop()  # nothing to do otherwise; an empty ``else if`` stays, for what comes after it
        self.add("}")
        loose = head.startswith(("if", "for")) and len(self.lines) == start + 3
        self._loose_braces = (start, len(self.lines)) if loose else (0, 0)

    def join(self) -> None:
        """Put the one statement of the block that has just ended behind its head: ``if (c) return x;``."""
        start, end = self._loose_braces
        if end == 0 or end != len(self.lines):
            return
        self._loose_braces = (0, 0)
        head, statement = self.lines[start].removesuffix(" {"), self.lines[start + 1].strip()
        if len(head) + len(statement) < LINE_LENGTH and not statement.startswith(("if ", "for ", "const ")):
            self.lines[start:end] = [f"{head} {statement}"]


def _is_code(before: str) -> bool:
    """Return whether a line that begins with ``before`` goes on outside a string and a comment."""
    if '"' not in before and "//" not in before:
        return True
    outside = re.sub(r'"(?:[^"\\]|\\.)*"', "", before)
    return '"' not in outside and "//" not in outside


def wrapped(line: str, length: int = LINE_LENGTH - 4) -> list[str]:
    """Break a long line after commas and before operators, with a hanging indent."""
    indent = line[: len(line) - len(line.lstrip())]
    rest, result = line[len(indent) :], list[str]()
    outer = len(indent)
    least = outer + 8  # no line is shorter
    at = 0  # where the rest of the line starts, which may be millions of characters long
    while len(indent) + len(rest) - at > length:
        part = indent + rest[at : at + length - len(indent)]
        ends = reversed([m.end() for m in _BREAK.finditer(part)])
        end = next((e for e in ends if e > least and _is_code(part[:e])), None)
        if end is None:
            break
        result.append(part[:end].rstrip())
        at += end - len(indent)
        while rest[at : at + 1].isspace():
            at += 1
        least = outer + 12
        indent = " " * (outer + (4 if len(result) == 1 else 8))
    return [*result, indent + rest[at:]]
