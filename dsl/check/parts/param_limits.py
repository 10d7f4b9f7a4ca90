# SPDX-License-Identifier: Apache-2.0
"""The least and largest values of an expression, as expressions of params: known when a solver starts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import count

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.inline import certain
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.undefined import undefined_operator
from hypgen.dsl.ir.walk import free_locals
from hypgen.dsl.types import Float, Int, length_of
from hypgen.dsl.types.units import PLAIN

Limits = tuple[ir.Expr, ir.Expr]
_Local = Mapping[str, Limits | None]  # None: the value of a binder, over which the limit runs itself
_COMPUTED = (
    ir.Const, ir.Local, ir.ParamRead, ir.TableRead, ir.ToFloat, ir.Unary, ir.Binary, ir.If, ir.Clamp,
    ir.LetIn, ir.Quantified, ir.Call,
)  # fmt: skip
_ROOTS = {"sqrt": -math.ulp(0.0), "exp": -math.inf, "log": 0.0, "log2": 0.0}  # a value above has a result
_MOST_EXPONENTS = 64  # of a power that are tried one by one


class Unlimited(Exception):  # noqa: N818  # no error: the answer that there are no limits
    """Raised where nothing limits an expression."""


class ParamLimits:
    """The limits of a model's expressions; state, draws and actions count by their types."""

    def __init__(
        self, params: Iterable[ir.Param], functions: Iterable[ir.Function], lets: Iterable[ir.Let]
    ) -> None:
        self._params = {p.name: p for p in params}
        self.functions = {f.name: f for f in functions}
        self._lets = {let.name: let for let in lets}
        self._numbers = count(1)

    def of_sum(self, e: ir.Expr, binder: ir.Binder | None) -> Limits:
        """Return the limits of ``e`` summed over a binder's values; raises ``Unlimited``."""
        if binder is None:
            return self.of(e, {})
        return self._sum(ir.Quantified(e.type, "sum", (binder,), None, e, None), {})

    def of(self, e: ir.Expr, local: _Local) -> Limits:
        """Return the least and largest value of a number as floats; raises ``Unlimited``."""
        if isinstance(e, ir.Local) and (found := local.get(e.name)) is not None:
            return found
        if self._is_known(e, local):
            parts = (node for node, _ in reached((e,), {}, {}) if isinstance(node, ir.Expr))
            if any(undefined_operator(part) and not self.reads_params(part) for part in parts):
                raise Unlimited
            return _plain(e), _plain(e)
        low, high = operators.ends(e.type)
        is_open = math.isinf(low) or math.isinf(high)
        if is_open or self.reads_params(e) or free_locals(e) & local.keys():
            try:
                return self._found(e, local)
            except Unlimited:
                if is_open:
                    raise
        return operators.real(low), operators.real(high)

    def _is_known(self, e: ir.Expr, local: _Local) -> bool:
        """Return whether ``e`` reads nothing but params and binders over which its limit runs."""
        if any(local[name] is not None for name in free_locals(e) & local.keys()):
            return False
        if not free_locals(e) <= local.keys():
            return False
        computed = all(isinstance(node, _COMPUTED) for node, _ in reached((e,), self.functions, {}))
        calls = (node for node, _ in reached((e,), {}, {}) if isinstance(node, ir.Call))
        return computed and all(map(self.reads_params, calls))  # of others, the body's limits say more

    def reads_params(self, e: ir.Expr) -> bool:
        """Return whether ``e`` reads a param, through functions and lets too."""
        return any(isinstance(node, ir.ParamRead) for node, _ in reached((e,), self.functions, self._lets))

    def _found(self, e: ir.Expr, local: _Local) -> Limits:
        match e:
            case ir.ParamRead():
                return self._entry(e, local)
            case ir.ToFloat(operand=operand):
                return self.of(operand, local)
            case ir.Unary(op="neg", operand=operand):
                low, high = self.of(operand, local)
                return operators.negate(high), operators.negate(low)
            case ir.Unary(op="abs", operand=operand):
                return operators.real(0.0), self._farthest(self.of(operand, local))
            case ir.Unary(op="sqrt" | "exp" | "log" | "log2" as op, operand=operand):
                low, high = self.of(operand, local)
                if not operators.ends(low.type)[0] > _ROOTS[op] and not self.reads_params(low):
                    raise Unlimited
                return operators.rising(op, low), operators.rising(op, high)
            case ir.Binary(op="add" | "min" | "max" as op, left=left, right=right):
                (a, b), (c, d) = self.of(left, local), self.of(right, local)
                return operators.arithmetic(op, a, c), operators.arithmetic(op, b, d)
            case ir.Binary(op="sub", left=left, right=right):
                (a, b), (c, d) = self.of(left, local), self.of(right, local)
                return operators.arithmetic("sub", a, d), operators.arithmetic("sub", b, c)
            case ir.Binary(op="mul", left=left, right=right):
                return _product(self.of(left, local), self.of(right, local))
            case ir.Binary(op="div", left=left, right=right):
                low, high = self.of(right, local)
                if low is not high and not operators.ends(low.type)[0] > 0.0:
                    raise Unlimited
                inverse = [operators.arithmetic("div", operators.real(1.0), end) for end in (high, low)]
                return _product(self.of(left, local), (inverse[0], inverse[1]))
            case ir.Binary(op="hypot", left=left, right=right):
                across, along = (self._farthest(self.of(side, local)) for side in (left, right))
                return operators.real(0.0), operators.hypotenuse(across, along)
            case ir.Binary(op="pow", left=left, right=right) if not isinstance(
                left, ir.Const
            ) and self._is_known(left, local):
                return self._powers(left, right)
            case ir.If(condition=condition, then=then, otherwise=otherwise):
                (a, b), (c, d) = self.of(then, local), self.of(otherwise, local)
                if self._is_known(condition, local):
                    return operators.choose(condition, a, c), operators.choose(condition, b, d)
                return operators.arithmetic("min", a, c), operators.arithmetic("max", b, d)
            case ir.LetIn(name=name, value=value, body=body):
                if operators.is_numeric(value.type):
                    return self.of(body, {**local, name: self.of(value, local)})
                return self.of(body, local)  # an enum or a record, which counts by its type
            case ir.Call(function=name, arguments=arguments):
                return self._call(name, arguments, local)
            case ir.LetRead(let=name) if (body := certain(self._lets[name].dist)) is not None:
                return self.of(body, {})
            case ir.Quantified(kind="sum"):
                return self._sum(e, local)
            case ir.Quantified(kind="min" | "max", binders=binders, body=body, otherwise=other) if body:
                low, high = self.of(body, {**local, **dict.fromkeys(b.name for b in binders)})
                least, most = _over(binders, "min", low), _over(binders, "max", high)
                if other is None:
                    return least, most
                a, b = self.of(other, local)
                return operators.arithmetic("min", least, a), operators.arithmetic("max", most, b)
        raise Unlimited

    def _entry(self, e: ir.ParamRead, local: _Local) -> Limits:
        """Return the least and largest entry that a read of a param may give."""
        binders: list[ir.Binder] = []
        indices: list[ir.Expr] = []
        for index, t in zip(e.indices, self._params[e.param].indices, strict=True):
            if not self._is_known(index, local):
                binders.append(ir.Binder(f"limit%{next(self._numbers)}", t))
                index = ir.Local(t, binders[-1].name)
            indices.append(index)
        entry = _plain(ir.ParamRead(e.type, e.param, tuple(indices)))
        return _over(tuple(binders), "min", entry), _over(tuple(binders), "max", entry)

    def _farthest(self, limits: Limits) -> ir.Expr:
        """Return the largest absolute value between two ends."""
        low, high = map(operators.absolute, limits)
        return low if limits[0] is limits[1] else operators.arithmetic("max", low, high)

    def _powers(self, base: ir.Expr, exponent: ir.Expr) -> Limits:
        """Return the least and largest power of a known base whose exponent is one of few ints."""
        whole = exponent.operand if isinstance(exponent, ir.ToFloat) else exponent
        if not isinstance(whole.type, Int) or whole.type.high - whole.type.low >= _MOST_EXPONENTS:
            raise Unlimited
        binder = ir.Binder(f"limit%{next(self._numbers)}", whole.type)
        power = _plain(operators.power(base, ir.Local(whole.type, binder.name)))
        return _over((binder,), "min", power), _over((binder,), "max", power)

    def _call(self, name: str, arguments: tuple[ir.Expr, ...], local: _Local) -> Limits:
        function = self.functions[name]
        given: dict[str, Limits | None] = {}
        for formal, argument in zip(function.formals, arguments, strict=True):
            if operators.is_numeric(formal.type):
                given[formal.name] = self.of(argument, local)
        return self.of(function.body, given)

    def _sum(self, e: ir.Quantified, local: _Local) -> Limits:
        assert e.body is not None
        low, high = self.of(e.body, {**local, **dict.fromkeys(b.name for b in e.binders)})
        if e.condition is not None:  # it may leave out any of them
            low = operators.arithmetic("min", low, operators.real(0.0))
            high = operators.arithmetic("max", high, operators.real(0.0))
        return _over(e.binders, "sum", low), _over(e.binders, "sum", high)


def _over(binders: tuple[ir.Binder, ...], kind: str, e: ir.Expr) -> ir.Expr:
    """Return the sum, least or largest of a limit over binders that it may read."""
    if not binders or (kind != "sum" and not free_locals(e) & {b.name for b in binders}):
        return e
    if isinstance(e, ir.Const):
        return operators.real(float(e.value) * length_of(tuple(b.type for b in binders)))
    return ir.Quantified(Float(), kind, binders, None, e, None)


def _product(a: Limits, b: Limits) -> Limits:
    for (x, same), (low, high) in ((a, b), (b, a)):
        least_factor, most_factor = operators.ends(x.type)
        if x is same and least_factor >= 0.0:
            return operators.arithmetic("mul", x, low), operators.arithmetic("mul", x, high)
        if x is same and most_factor <= 0.0:
            return operators.arithmetic("mul", x, high), operators.arithmetic("mul", x, low)
    if not any(all(isinstance(end, ir.Const) for end in ends) or ends[0] is ends[1] for ends in (a, b)):
        raise Unlimited  # the products of products would grow without bound
    products = [operators.arithmetic("mul", x, y) for x in dict.fromkeys(a) for y in dict.fromkeys(b)]
    least = most = products[0]
    for product in products[1:]:
        least, most = (operators.arithmetic(op, end, product) for op, end in (("min", least), ("max", most)))
    return least, most


def _plain(e: ir.Expr) -> ir.Expr:
    return operators.measured(operators.to_float(e), PLAIN)
