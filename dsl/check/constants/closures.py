# SPDX-License-Identifier: Apache-2.0
"""Constant expressions as Python closures: the entries of a large table, each in a microsecond.

Checking an expression anew for every value of its binders takes some hundred times as long, and walking it
some fifteen times. Here it has been checked once; the closures compute what constant folding would, by the
same table of operators, and give up where folding would.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.ir import evaluate
from hypgen.dsl.ir.evaluate import single, value_at
from hypgen.dsl.ir.walk import children
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Float, low_of, size_of

Values = dict[str, Any]
Code = Callable[[Values], Any]


class Irregular(Exception):
    """Closures do not tell the value: the expression is not constant, or folding it meets a mistake."""


def combinations(binders: tuple[ir.Binder, ...]) -> Iterator[tuple[bool | int, ...]]:
    """Yield the values of all binders in lexicographic order."""
    return product(*([value_at(b.type, i) for i in range(size_of(b.type))] for b in binders))


class Closures:
    """Makes closures of expressions that read nothing but locals and constants."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._functions: dict[str, Code] = {}
        self._costs: dict[str, int] = {}

    def cost(self, e: ir.Expr) -> int:
        """Return how many nodes an evaluation of ``e`` passes at most."""
        if isinstance(e, ir.Quantified):
            count = math.prod(size_of(b.type) for b in e.binders)
            return 1 + count * (1 + sum(self.cost(c) for c in (e.condition, e.body) if c is not None))
        total = 1 + sum(self.cost(c) for c in children(e) if isinstance(c, ir.Expr))
        if isinstance(e, ir.Call):
            if e.function not in self._costs:
                self._costs[e.function] = self.cost(self._function(e.function).body)
            total += self._costs[e.function]
        return total

    def code(self, e: ir.Expr) -> Code:
        """Return the closure of ``e``; raises ``Irregular``, as the closure does where folding would fail.

        Arithmetic of Python may raise ``ArithmeticError`` or ``ValueError`` to the same end.
        """
        match e:
            case ir.Const(_, value):
                return lambda _: value
            case ir.Local(_, name):
                return operator.itemgetter(name)
            case ir.TableRead():
                return self._table_read(e)
            case ir.Call(_, name, arguments):
                return self._call(name, arguments)
            case ir.Binary(_, "and" | "or" as op, left, right):
                return self._logical(op, self.code(left), self.code(right))
            case ir.Binary(_, "floordiv" | "mod", _, right):
                return self._division(e, self.code(right))
            case ir.If(_, condition, then, otherwise):
                test, yes, no = self.code(condition), self.code(then), self.code(otherwise)
                return lambda env: yes(env) if test(env) else no(env)
            case ir.LetIn(_, name, value, body):
                bound, result = self.code(value), self.code(body)
                return lambda env: result({**env, name: bound(env)})
            case ir.Quantified():
                return self._quantified(e)
        return self._operation(e)

    def _function(self, name: str) -> ir.Function:
        if name in self._program.unrolled:
            return self._program.unrolled[name]
        return self._program.function(self._program.symbols.functions[name])

    def _table_read(self, e: ir.TableRead) -> Code:
        item = self._program.symbols.values[e.table]
        assert isinstance(item, ast.Const)
        table = self._program.const(item)
        assert isinstance(table, ir.ConstantArray)
        values, places = table.values, []
        for number, (index, t) in enumerate(zip(e.indices, table.indices, strict=True)):
            stride = math.prod(map(size_of, table.indices[number + 1 :]))
            places.append((self.code(index), stride, low_of(t)))
        return lambda env: values[sum((index(env) - low) * stride for index, stride, low in places)]

    def _call(self, name: str, arguments: tuple[ir.Expr, ...]) -> Code:
        function = self._function(name)
        if name not in self._functions:
            self._functions[name] = self.code(function.body)
        body, given = self._functions[name], [self.code(a) for a in arguments]
        formals = [f.name for f in function.formals]
        return lambda env: body({f: g(env) for f, g in zip(formals, given, strict=True)})

    def _operation(self, e: ir.Expr) -> Code:
        function = evaluate.of_node(e)
        if function is None:
            raise Irregular
        parts = [self.code(child) for child in children(e) if isinstance(child, ir.Expr)]
        if len(parts) == 1:
            (only,) = parts
            return lambda env: function(only(env))
        if len(parts) == 2:
            left, right = parts
            return lambda env: function(left(env), right(env))
        return lambda env: function(*[part(env) for part in parts])

    @staticmethod
    def _logical(op: str, left: Code, right: Code) -> Code:
        if op == "and":
            return lambda env: left(env) and right(env)
        return lambda env: left(env) or right(env)

    def _division(self, e: ir.Binary, divisor: Code) -> Code:
        quotient = self._operation(e)

        def checked(env: Values) -> Any:
            if divisor(env) == 0:
                raise Irregular  # the checker refuses it
            return quotient(env)

        return checked

    def _quantified(self, e: ir.Quantified) -> Code:
        names = [b.name for b in e.binders]
        test = None if e.condition is None else self.code(e.condition)
        body = (lambda _: 1) if e.body is None else self.code(e.body)
        otherwise = None if e.otherwise is None else self.code(e.otherwise)

        def matches(env: Values) -> Iterator[tuple[Any, Any]]:
            inner = dict(env)
            for values in combinations(e.binders):
                inner.update(zip(names, values, strict=True))
                if test is None or test(inner):
                    yield values[0], body(inner)

        def total(env: Values) -> Any:
            result: Any = 0.0 if isinstance(e.type, Float) else 0
            for _, value in matches(env):
                result = single(result + value) if isinstance(e.type, Float) else result + value
            return result

        def extreme(env: Values) -> Any:
            best: tuple[Any, Any] | None = None
            for found in matches(env):
                smaller = best is not None and (
                    found[1] < best[1] if e.kind.endswith("min") else best[1] < found[1]
                )
                best = found if best is None or smaller else best
            if best is None:
                if otherwise is None:
                    raise Irregular
                return otherwise(env)
            return best[0] if e.kind.startswith("arg") else best[1]

        match e.kind:
            case "any":
                return lambda env: any(value for _, value in matches(env))
            case "all":
                return lambda env: all(value for _, value in matches(env))
            case "sum" | "count":
                return total
        return extreme
