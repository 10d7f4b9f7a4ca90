# SPDX-License-Identifier: Apache-2.0
"""How far expressions are from the real numbers of their text.

Literals, params and what is computed of them are float32. States are what the model says: a float variable is
a float32. So is a condition: it counts as 32-bit floats decide it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

from hypgen.dsl import ir
from hypgen.dsl.ir.inline import certain
from hypgen.dsl.ir.reward_scale import Ranges
from hypgen.dsl.types import Float, length_of
from hypgen.dsl.types.intervals import ESTIMATE, Ends, half_place, hull

Local = Mapping[str, tuple[Ends, float]]  # ranges and errors of locals

_FUNCTION = 2.0**-22  # of a function that is rounded from double
_TINY = 2.0**-149  # the least float32 above 0
_TINY_PART = 2.0**-24  # of an error that is itself rounded
_GRID = 1 << 12  # a computed constant on this grid ..
_WHOLE = 1 << 24  # .. below this is taken for what the text says


class ExpressionErrors:
    """Bounds of the differences of a model's expressions."""

    def __init__(self, model: ir.Model) -> None:
        self._ranges = Ranges(model)
        self._params = {p.name: p for p in model.params}
        self._tables = {t.name: t for t in model.tables}
        self._lets = {let.name: let for let in model.all_lets}
        self._functions = {f.name: f for f in model.functions}

    def ends(self, e: ir.Expr, local: Local) -> Ends:
        """Return the range of a number."""
        if isinstance(e, ir.ParamRead) and (default := self._params[e.param].default):
            return hull(map(float, default))
        return self._ranges.of(e, {name: ends for name, (ends, _) in local.items()})

    def _width(self, e: ir.Expr, local: Local) -> float:
        low, high = self.ends(e, local)
        return high - low

    def size(self, e: ir.Expr, local: Local) -> float:
        """Return the largest size of a number."""
        return max(map(abs, self.ends(e, local)))

    def of(self, e: ir.Expr, local: Local) -> float:
        """Return a bound of the difference; 0 of what is no float."""
        if not isinstance(e.type, Float):
            return 0.0
        found = self._found(e, local)
        if found <= 1e-3 * self.size(e, local):
            return found
        return min(found, self._width(e, local) + half_place(self.size(e, local)))

    def _found(self, e: ir.Expr, local: Local) -> float:
        size = self.size(e, local)
        match e:
            case ir.Const(value=value, exact=exact) if exact is not None:
                return float(abs(exact - Fraction(value))) * (1.0 + _TINY_PART)
            case ir.Const(value=value):
                # A literal would have its exact number if it were rounded: this is one, or it was computed.
                is_whole = float(value * _GRID).is_integer() and abs(value) < _WHOLE
                return 0.0 if is_whole else size * ESTIMATE
            case ir.ParamRead(param=name):
                return self._params[name].error
            case ir.TableRead(table=name):
                return self._tables[name].error
            case ir.Local(name=name):
                return local[name][1] if name in local else 0.0
            case ir.ToFloat():
                return half_place(size) if size > 1 << 24 else 0.0
            case ir.Unary(op="neg" | "abs", operand=operand):
                return self.of(operand, local)
            case ir.Unary(op=op, operand=operand):
                return _of_function(op, self.ends(operand, local), self.of(operand, local), size)
            case ir.Binary(op="pow", left=left, right=right):
                return self._of_power(left, right, local, size)
            case ir.Binary(op="hypot", left=left, right=right):
                return self.of(left, local) + self.of(right, local) + size * _FUNCTION + _TINY
            case ir.Binary(op="min" | "max", left=left, right=right):
                return max(self.of(left, local), self.of(right, local))
            case ir.Binary(op="add" | "sub", left=left, right=right):
                return self.of(left, local) + self.of(right, local) + half_place(size)
            case ir.Binary(op="mul", left=left, right=right):
                a, b = self.of(left, local), self.of(right, local)
                by_left, by_right = _times(self.size(right, local) + b, a), _times(self.size(left, local), b)
                return by_left + by_right + half_place(size)
            case ir.Binary(op="div", left=left, right=right):
                low, high = self.ends(right, local)
                a, b = self.of(left, local), self.of(right, local)
                least = min(abs(low), abs(high)) - b if low * high > 0 else 0.0
                return math.inf if least <= 0 else (a + _times(size, b)) / least + half_place(size)
            case ir.Clamp(operand=operand):
                return max(self.of(operand, local), half_place(size))
            case ir.If(then=then, otherwise=otherwise):
                return max(self.of(then, local), self.of(otherwise, local))
            case ir.LetIn(name=name, value=value, body=body):
                return self.of(body, {**local, name: self.pair(value, local)})
            case ir.Call(function=name, arguments=arguments):
                function = self._functions[name]
                pairs = (self.pair(a, local) for a in arguments)
                names = (f.name for f in function.formals)
                return self.of(function.body, dict(zip(names, pairs, strict=True)))
            case ir.LetRead(let=name):
                body = certain(self._lets[name].dist)
                return 0.0 if body is None else self.of(body, {})
            case ir.Quantified(kind="sum", binders=binders, body=body) if body is not None:
                count = length_of(tuple(b.type for b in binders))
                return count * (self.of(body, local) + half_place(count * self.size(body, local)))
            case ir.Quantified(kind="min" | "max", body=body, otherwise=other) if body is not None:
                return max(self.of(part, local) for part in (body, other) if part is not None)
            case ir.StateRead():
                return 0.0
        return self._width(e, local)

    def _of_power(self, left: ir.Expr, right: ir.Expr, local: Local, size: float) -> float:
        """Return how far a power may be: that of its logarithm, and the rounding of the function."""
        low, high = self.ends(left, local)
        a, b = self.of(left, local), self.of(right, local)
        if isinstance(right, ir.ToFloat) and low >= 0.0 and (most := self.ends(right, local)[1]) < 100.0:
            steep = most * max(1.0, high + a) ** max(0.0, most - 1.0)  # a whole power
            return _times(steep, a) + size * _FUNCTION + _TINY
        if low - a <= 0.0 or math.isinf(high):
            return math.inf if a or b else size * _FUNCTION + _TINY
        steep = max(abs(math.log(low - a)), abs(math.log(high + a)))
        power = self.size(right, local) + b
        return _grown(size, _times(steep, b) + _times(power, a / (low - a))) + size * _FUNCTION + _TINY

    def pair(self, e: ir.Expr, local: Local) -> tuple[Ends, float]:
        """Return what is known of a local that stands for ``e``."""
        return self.ends(e, local), self.of(e, local)


def _of_function(op: str, ends: Ends, error: float, size: float) -> float:
    """Return how far a function's value may be, given the ends and the error of its operand."""
    low = ends[0] - error
    match op:
        case _ if error == 0.0:
            found = 0.0
        case "exp":
            found = _grown(size, error)
        case "log" | "log2":
            found = 1.5 * error / low if low > 0.0 else math.inf
        case "sqrt":
            found = min(error / math.sqrt(low), math.sqrt(error)) if low > 0.0 else math.sqrt(2.0 * error)
        case "sin" | "cos":
            found = error
        case _:
            found = math.inf
    return found + size * _FUNCTION + _TINY


def _grown(size: float, error: float) -> float:
    """Return how far a number is whose logarithm is off by ``error``."""
    return _times(size, math.expm1(error)) if error < 100.0 else math.inf


def _times(a: float, b: float) -> float:
    return a * b if a and b else 0.0
