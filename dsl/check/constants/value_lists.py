"""Strings that list an array's entries, separated by blanks: numbers, booleans, or variants without glyphs.

Large tables are written so. A word of a string takes a tenth of the time that an expression takes to read.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import partial

from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.messages.report import Mistake, gather, mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Bool, Enum, Float, Int, Type, intervals

_WORD = re.compile(r"\S+")
_INT = re.compile(r"-?\d{1,10}")
_FLOAT = re.compile(r"-?\d+(\.\d+)?([eE][+-]?\d+)?")


def listed(node: ast.Expr, element: Type, count: int, name: str) -> tuple[Value, ...]:
    """Return the ``count`` entries that a string, or a list of strings, gives in order."""
    known = _known(element)
    rows = gather([partial(_row, text, span, element, known) for text, span in _strings(node)])
    values = tuple(value for row in rows for value in row)
    if len(values) != count:
        given = f"{len(values)} {'is' if len(values) == 1 else 'are'}"
        raise mistake(
            "E0309",
            f"'{name}' takes {count} entries, but {given} listed",
            node.span,
            "give one for each value of its indexes, in order",
        )
    return values


def _strings(node: ast.Expr) -> Iterator[tuple[str, Span]]:
    if isinstance(node, ast.ArrayLiteral):
        for item in node.items:
            yield from _strings(item)
    elif isinstance(node, ast.Literal) and isinstance(node.value, str):
        yield node.value, node.span
    else:
        raise mistake(
            "E0311",
            "strings stand beside other entries here",
            node.span,
            "write all entries in strings, or none",
        )


def _known(element: Type) -> dict[str, Value]:
    """Return what words other than numbers mean."""
    if isinstance(element, Bool):
        return {"false": False, "true": True}
    if isinstance(element, Enum):
        return {v.name: element.offsets[v.name] for v in element.variants if v.argument is None}
    return {}


def _row(text: str, span: Span, element: Type, known: dict[str, Value]) -> list[Value]:
    result: list[Value] = []
    mistakes: list[Mistake] = []
    for match in _WORD.finditer(text):
        value = known.get(match.group())
        if value is None:
            value = _number(match.group(), element)
        if value is None:
            mistakes.append(_no_entry(match, span, element, known))
        else:
            result.append(value)
    if mistakes:
        raise Mistake([d for m in mistakes[:3] for d in m.diagnostics])
    return result


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


def _no_entry(match: re.Match[str], string: Span, element: Type, known: dict[str, Value]) -> Mistake:
    column = string.column + 1 + match.start()
    span = Span(string.file, string.line, column, string.line, column + len(match.group()))
    remedy = "a string lists numbers, separated by blanks"
    if isinstance(element, Enum):
        remedy = "list the names of variants, separated by blanks"
        remedy += ', or give them glyphs, as in enum Cell { floor ".", wall "#" }'
        if not any(v.argument is None for v in element.variants):
            remedy = "write a list"
    elif isinstance(element, Bool):
        remedy = "list true and false, separated by blanks"
    nearest = did_you_mean(match.group(), known)
    kind = f"enum '{element}'" if isinstance(element, Enum) else f"'{element}'"
    return mistake("E0311", f"'{match.group()}' is no value of {kind}", span, nearest or remedy)
