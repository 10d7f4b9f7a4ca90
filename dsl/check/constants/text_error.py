# SPDX-License-Identifier: Apache-2.0
"""The numbers that the text says of a constant's entries, and how far the entries are from them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fractions import Fraction

from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk
from hypgen.dsl.types import Float, Type, intervals

_FRACTION = re.compile(r"\.0*[1-9]|[eE]")  # of a number in a list that is not whole
_WHOLE = 1 << 24  # float32 has all whole numbers below
_MOST_EXACT = 1 << 12  # entries whose exact numbers are kept
_MOST_DIGITS = 400  # doubles have no smaller numbers


def error_of(node: ast.Expr, element: Type, values: Sequence[Value]) -> float:
    """Return a bound of the error of all entries of ``node``; an estimate where they are computed."""
    if not isinstance(element, Float) or not values:
        return 0.0
    size = max(abs(float(value)) for value in values)
    parts = list(walk(node))
    if not all(isinstance(p, ast.Literal | ast.ArrayLiteral) or _is_sign(p) for p in parts):
        return size * intervals.ESTIMATE
    if size < _WHOLE and all(_is_exact(p) for p in parts if isinstance(p, ast.Literal)):
        return 0.0
    return intervals.half_place(size)


def exact_numbers(node: ast.Expr, element: Type, count: int) -> tuple[Fraction, ...] | None:
    """Return the numbers that ``node`` lists; None where it does not list all ``count`` of them, or many."""
    if not isinstance(element, Float) or count > _MOST_EXACT:
        return None
    numbers = list(_listed(node))
    found = tuple(number for number in numbers if number is not None)
    return found if len(found) == len(numbers) == count else None


def _listed(node: ast.Expr) -> Iterator[Fraction | None]:
    match node:
        case ast.ArrayLiteral(items=items):
            for item in items:
                yield from _listed(item)
        case ast.Literal(value=str() as words):
            yield from map(_number, words.split())
        case ast.Literal(value=int() | float() as value, exact=exact):
            yield Fraction(value) if exact is None else exact
        case ast.Unary(op="-", operand=operand):
            for number in _listed(operand):
                yield None if number is None else -number
        case _:
            yield None


def _number(word: str) -> Fraction | None:
    """Return the number; None for one whose digits in full are more than any use has."""
    exponent = word.lower().partition("e")[2]
    return None if exponent and abs(int(exponent)) > _MOST_DIGITS else Fraction(word)


def _is_sign(node: ast.Node) -> bool:
    return isinstance(node, ast.Unary) and node.op == "-"


def _is_exact(literal: ast.Literal) -> bool:
    if isinstance(literal.value, str):
        return _FRACTION.search(literal.value) is None
    return literal.exact is None or Fraction(intervals.float32(float(literal.exact))) == literal.exact
