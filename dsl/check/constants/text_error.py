# SPDX-License-Identifier: Apache-2.0
"""How far the entries of a constant are from the numbers that the text says."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction

from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk
from hypgen.dsl.types import Float, Type, intervals

_FRACTION = re.compile(r"\.0*[1-9]|[eE]")  # of a number in a list that is not whole
_WHOLE = 1 << 24  # float32 has all whole numbers below


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


def _is_sign(node: ast.Node) -> bool:
    return isinstance(node, ast.Unary) and node.op == "-"


def _is_exact(literal: ast.Literal) -> bool:
    if isinstance(literal.value, str):
        return _FRACTION.search(literal.value) is None
    return literal.exact is None or Fraction(intervals.float32(float(literal.exact))) == literal.exact
