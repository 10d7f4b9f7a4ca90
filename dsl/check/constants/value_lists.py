# SPDX-License-Identifier: Apache-2.0
"""Strings that list an array's entries, separated by blanks: numbers, booleans, or variants without glyphs.

Large tables are written so. A word of a string takes a tenth of the time that an expression takes to read.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator, Sequence
from functools import partial

from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.messages import e03_values
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Bool, Enum, Float, Int, Type, intervals

_WORD = re.compile(r"\S+")
_INT = re.compile(r"-?\d{1,10}")
_FLOAT = re.compile(r"-?\d+(\.\d+)?([eE][+-]?\d+)?")
_INTS = re.compile(rf"(?:\s*{_INT.pattern}(?!\S))*\s*")
_FLOATS = re.compile(rf"(?:\s*{_FLOAT.pattern}(?!\S))*\s*")


def listed(node: ast.Expr, element: Type, count: int, name: str) -> tuple[Value, ...]:
    """Return the ``count`` entries that a string, or a list of strings, gives in order."""
    known = _known(element)
    rows = gather([partial(_row, text, span, element, known) for text, span in _strings(node)])
    values = tuple(value for row in rows for value in row)
    if len(values) != count:
        raise Mistake(e03_values.wrong_number_listed(name, count, len(values), node.span))
    return values


def _strings(node: ast.Expr) -> Iterator[tuple[str, Span]]:
    if isinstance(node, ast.ArrayLiteral):
        for item in node.items:
            yield from _strings(item)
    elif isinstance(node, ast.Literal) and isinstance(node.value, str):
        yield node.value, node.span
    else:
        raise Mistake(e03_values.string_beside_others(node.span))


def _known(element: Type) -> dict[str, Value]:
    """Return what words other than numbers mean."""
    if isinstance(element, Bool):
        return {"false": False, "true": True}
    if isinstance(element, Enum):
        return {v.name: element.offsets[v.name] for v in element.variants if v.argument is None}
    return {}


def _row(text: str, span: Span, element: Type, known: dict[str, Value]) -> Sequence[Value]:
    numbers = _numbers(text, element)
    if numbers is not None:
        return numbers
    result: list[Value] = []
    found: list[Diagnostic] = []
    for match in _WORD.finditer(text):
        value = known.get(match.group())
        if value is None:
            value = _number(match.group(), element)
        if value is None:
            found.append(_no_entry(match, span, element, known))
        else:
            result.append(value)
    if found:
        raise Mistake(*found[:3])
    return result


def _numbers(text: str, element: Type) -> Sequence[Value] | None:
    """Return a string's numbers if all words are numbers of the type; what else they are is told by word."""
    if isinstance(element, Int) and _INTS.fullmatch(text):
        whole = [int(word) for word in text.split()]
        return whole if all(element.low <= number <= element.high for number in whole) else None
    if isinstance(element, Float) and _FLOATS.fullmatch(text):
        numbers = [float(word) for word in text.split()]
        inside = all(math.isfinite(number) and element.low <= number <= element.high for number in numbers)
        return array("f", numbers).tolist() if inside else None  # rounds to float32
    return None


def _number(word: str, element: Type) -> Value | None:
    """Return the number that a word writes, None if it is none of the type's."""
    if isinstance(element, Int):
        value = int(word) if _INT.fullmatch(word) else None
        return value if value is not None and element.low <= value <= element.high else None
    if isinstance(element, Float) and _FLOAT.fullmatch(word):
        number = float(word)
        inside = math.isfinite(number) and element.low <= number <= element.high
        return intervals.float32(number) if inside else None
    return None


def _no_entry(match: re.Match[str], string: Span, element: Type, known: dict[str, Value]) -> Diagnostic:
    column = string.column + 1 + match.start()
    span = Span(string.file, string.line, column, string.line, column + len(match.group()))
    return e03_values.unknown_entry(match.group(), element, known, span)
