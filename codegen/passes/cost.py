# SPDX-License-Identifier: Apache-2.0
"""The cost of an expression, in simple operations: enough to tell a walk from a table's load.

A function costs as much at each of its calls, which ``ir.reads`` goes through once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Node, children
from hypgen.dsl.types import size_of

_DIVISION = 8
_CONSTANT_DIVISION = 3  # compilers multiply instead
_BRANCH = 2  # often more: a branch that the processor mispredicts costs a dozen operations


class Costs:
    """The cost of a model's expressions, through functions and lets."""

    def __init__(self, functions: Mapping[str, ir.Function], lets: Mapping[str, ir.Let]) -> None:
        self.functions = functions
        self.lets = lets
        self.known: dict[tuple[type[Node], str], int] = {}  # of bodies, by what reads them and its name

    def of(self, node: Node) -> int:
        """Return how many simple operations ``node`` takes; both sides of a condition count."""
        inside = sum(self.of(child) for child in children(node))
        match node:
            case ir.Const() | ir.Local() | ir.Certain():
                return inside
            case ir.StateRead(indices=()):
                return 0
            case ir.Call(function=name):
                return inside + self._of_body(ir.Call, name, self.functions[name].body)
            case ir.LetRead(let=name):
                let = self.lets[name]
                return inside + (0 if let.draws else self._of_body(ir.LetRead, name, let.dist))
            case (
                ir.Quantified(binders=binders) | ir.UniformSet(binders=binders) | ir.Weighted(binders=binders)
            ):
                return (1 + inside) * math.prod(size_of(b.type) for b in binders)
            case ir.If():
                return _BRANCH + inside
            case ir.Binary(op="floordiv" | "mod", right=right):
                return inside + _division(right)
            case ir.FieldRead(record=record, field=field):
                stride, size = record.stride(field), size_of(record.field_type(field) or record)
                apart = [n for n in (stride, size) if n & (n - 1)]  # by a power of two it is a shift
                return inside + 1 + (_CONSTANT_DIVISION - 1) * bool(apart)
            case ir.MakeRecord(values=values):
                return inside + len(values)
        return inside + 1

    def _of_body(self, reader: type[Node], name: str, body: Node) -> int:
        if (reader, name) not in self.known:
            self.known[reader, name] = self.of(body)
        return self.known[reader, name]


def _division(divisor: ir.Expr) -> int:
    return _CONSTANT_DIVISION if isinstance(divisor, ir.Const) else _DIVISION
