# SPDX-License-Identifier: Apache-2.0
"""Which parts of an expression have no value, as the square root of -1: NaN or infinite when a model runs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.evaluate import Value, of_node
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.walk import Node, children
from hypgen.dsl.types import Float

_WRITTEN = {"div": "/", "mul": "*", "add": "+", "sub": "-", "pow": "**"}


def may_be_undefined(nodes: Iterable[Node], functions: Mapping[str, ir.Function]) -> str | None:
    """Return the first function or operator, as written, that has no value for some operands."""
    return next((op for node, _ in reached(nodes, functions, {}) if (op := undefined_operator(node))), None)


def undefined_operator(node: Node) -> str | None:
    """Return the function or operator of a node, as written, if it has no value for some operands."""
    match node:
        case ir.Unary(_, "sqrt", operand) if operators.ends(operand.type)[0] < 0:
            return "sqrt"
        case ir.Unary(_, "log" | "log2" as op, operand) if operators.ends(operand.type)[0] <= 0:
            return op
        case ir.Binary(_, "div", _, right):
            low, high = operators.ends(right.type)
            return "/" if low <= 0 <= high else None
        case ir.Unary(_, "asin" | "acos" as op, operand):
            low, high = operators.ends(operand.type)
            return op if low < -1 or high > 1 else None
        case ir.Binary(_, "pow", base, exponent):
            least = operators.ends(base.type)[0]
            return "**" if least < 0 or (least == 0 and operators.ends(exponent.type)[0] < 0) else None
    return None


def never_finite(e: ir.Expr, params: Mapping[str, ir.Param]) -> str:
    """Return what makes ``e`` infinite or no number in every state, at the defaults of params; '' if not."""
    try:
        value = _value(e, params)
    except _WithoutValueError as problem:
        return problem.what
    return f"it is {value:g}" if isinstance(value, float) and not math.isfinite(value) else ""


def partly_never_finite(e: ir.Expr, params: Mapping[str, ir.Param]) -> str:
    """Return what makes a part of ``e`` infinite or no number, at the defaults of params; '' if nothing.

    Branches that these defaults do not take have no part in it, nor do parts that read anything else.
    """
    try:
        value = _value(e, params)
    except _WithoutValueError as problem:
        return problem.what
    if value is not None:
        return f"a part is {value:g}" if isinstance(value, float) and not math.isfinite(value) else ""
    parts = [child for child in children(e) if isinstance(child, ir.Expr)]
    if isinstance(e, ir.If):
        with suppress(_WithoutValueError):
            condition = _value(e.condition, params)
            if condition is not None:
                parts = [e.then if condition else e.otherwise]
    return next((why for part in parts if (why := partly_never_finite(part, params))), "")


class _WithoutValueError(Exception):
    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what


def _value(e: ir.Expr, params: Mapping[str, ir.Param]) -> Value | None:
    """Return the value of what reads nothing but params; None where it is not known."""
    if isinstance(e, ir.Const):
        return e.value
    if isinstance(e, ir.ParamRead) and not e.indices:
        default = params[e.param].default
        return None if default is None else default[0]
    if isinstance(e, ir.If):
        condition = _value(e.condition, params)
        return None if condition is None else _value(e.then if condition else e.otherwise, params)
    operation = of_node(e)
    if operation is None:
        return None
    known = [_value(child, params) for child in children(e) if isinstance(child, ir.Expr)]
    values = [value for value in known if value is not None]
    if len(values) < len(known):
        return None
    try:
        result: Value = operation(*values)
    except (ArithmeticError, ValueError):
        if not isinstance(e.type, Float) or not isinstance(e, ir.Unary | ir.Binary):
            return None
        operands = " and ".join(f"{value:g}" for value in values)
        raise _WithoutValueError(f"'{_WRITTEN.get(e.op, e.op)}' of {operands} is not finite") from None
    return result
