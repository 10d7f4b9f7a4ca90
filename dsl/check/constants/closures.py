"""Constant expressions as Python closures: the entries of a large table, each in a microsecond.

Checking an expression anew for every value of its binders takes some hundred times as long. Here it has been
checked once; the closures compute what constant folding would, and give up where folding would.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.ir.operators import COMPARISONS
from hypgen.dsl.ir.walk import children
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Bool, Float, Int, Type, low_of, size_of

Value = bool | int | float
Values = dict[str, Any]
Code = Callable[[Values], Any]


class Irregular(Exception):
    """Closures do not tell the value: the expression is not constant, or folding it meets a mistake."""


_FLOAT32 = struct.Struct("<f")


def _single(value: float) -> float:
    """Return ``value`` as float32; what overflows or is no number is for the checker."""
    result: float = _FLOAT32.unpack(_FLOAT32.pack(value))[0]
    if not math.isfinite(result):
        raise Irregular
    return result


def _smaller(a: Any, b: Any) -> Any:
    return b if b < a else a


def _larger(a: Any, b: Any) -> Any:
    return b if a < b else a


def _sign(x: Any) -> int:
    return int(x > 0) - int(x < 0)


_INT: dict[str, Callable[[Any, Any], Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "floordiv": operator.floordiv,
    "mod": operator.mod,
    "min": _smaller,
    "max": _larger,
}
_FLOAT: dict[str, Callable[[Any, Any], float]] = {
    "add": lambda a, b: _single(a + b),
    "sub": lambda a, b: _single(a - b),
    "mul": lambda a, b: _single(a * b),
    "div": lambda a, b: _single(a / b),
    "pow": lambda a, b: _single(math.pow(a, b)),
    "hypot": lambda a, b: _single(math.hypot(a, b)),
    "min": _smaller,
    "max": _larger,
}
_UNARY: dict[str, Callable[[Any], Any]] = {
    "neg": operator.neg,
    "not": operator.not_,
    "abs": abs,
    "sqrt": lambda x: _single(math.sqrt(x)),
    "exp": lambda x: _single(math.exp(x)),
    "log": lambda x: _single(math.log(x)),
    "log2": lambda x: _single(math.log2(x)),
}
_ROUNDING: dict[str, Callable[[float], int]] = {"floor": math.floor, "ceil": math.ceil, "round": round}


def value_at(t: Type, position: int) -> bool | int:
    """Return the value of a finite type with this number, counted from 0."""
    return bool(position) if isinstance(t, Bool) else position + low_of(t)


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
            case ir.ToFloat(_, operand):
                inner = self.code(operand)
                return lambda env: _single(inner(env))
            case ir.Unary():
                return self._unary(e)
            case ir.Binary():
                return self._binary(e)
            case ir.Clamp(_, operand, low, high):
                inner = self.code(operand)
                return lambda env: min(max(inner(env), low), high)
            case ir.If(_, condition, then, otherwise):
                test, yes, no = self.code(condition), self.code(then), self.code(otherwise)
                return lambda env: yes(env) if test(env) else no(env)
            case ir.LetIn(_, name, value, body):
                bound, result = self.code(value), self.code(body)
                return lambda env: result({**env, name: bound(env)})
            case ir.IsVariant() | ir.VariantArgument() | ir.MakeVariant():
                return self._variant(e)
            case ir.FieldRead(_, record, name, operand):
                inner, t, stride = self.code(operand), record.field_type(name), record.stride(name)
                assert t is not None
                size, field = size_of(t), t
                return lambda env: value_at(field, inner(env) // stride % size)
            case ir.MakeRecord(_, record, values):
                parts = [
                    (self.code(v), record.stride(n), low_of(t))
                    for (n, t), v in zip(record.fields, values, strict=True)
                ]
                return lambda env: sum((part(env) - low) * stride for part, stride, low in parts)
            case ir.Quantified():
                return self._quantified(e)
        raise Irregular

    def _function(self, name: str) -> ir.Function:
        if name in self._program.unrolled:
            return self._program.unrolled[name]
        item = self._program.symbols.globals[name]
        assert isinstance(item, ast.Function)
        return self._program.function(item)

    def _table_read(self, e: ir.TableRead) -> Code:
        item = self._program.symbols.globals[e.table]
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

    def _unary(self, e: ir.Unary) -> Code:
        inner = self.code(e.operand)
        if e.op == "sign":
            kind = float if isinstance(e.type, Float) else int
            return lambda env: kind(_sign(inner(env)))
        if e.op in _ROUNDING:
            assert isinstance(e.type, Int)
            low, high, rounded = e.type.low, e.type.high, _ROUNDING[e.op]
            return lambda env: min(max(rounded(inner(env)), low), high)
        if e.op not in _UNARY:
            raise Irregular
        function = _UNARY[e.op]
        return lambda env: function(inner(env))

    def _binary(self, e: ir.Binary) -> Code:
        left, right = self.code(e.left), self.code(e.right)
        if e.op == "and":
            return lambda env: left(env) and right(env)
        if e.op == "or":
            return lambda env: left(env) or right(env)
        table = COMPARISONS if e.op in COMPARISONS else _FLOAT if isinstance(e.type, Float) else _INT
        if e.op not in table:
            raise Irregular
        function = table[e.op]
        return lambda env: function(left(env), right(env))

    def _variant(self, e: ir.IsVariant | ir.VariantArgument | ir.MakeVariant) -> Code:
        variant = e.enum.variant(e.variant)
        assert variant is not None
        first, argument = e.enum.offsets[e.variant], variant.argument
        if isinstance(e, ir.MakeVariant):
            assert argument is not None
            low, inner = low_of(argument), self.code(e.argument)
            return lambda env: inner(env) - low + first
        inner = self.code(e.operand)
        if isinstance(e, ir.IsVariant):
            end = first + (1 if argument is None else size_of(argument))
            return lambda env: first <= inner(env) < end
        assert argument is not None
        t = argument
        return lambda env: value_at(t, inner(env) - first)

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
                result = _single(result + value) if isinstance(e.type, Float) else result + value
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
