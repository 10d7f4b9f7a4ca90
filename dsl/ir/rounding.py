# SPDX-License-Identifier: Apache-2.0
"""How far a model's rewards and draws are from the real numbers of its text.

Literals, params and what is computed of them are float32. Rewards are then in fixed point, and draws compare
with whole numbers of 2^-32 or 2^-63. States are what the model says: a float variable is a float32. So is a
condition: it counts as 32-bit floats decide it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

from hypgen.dsl import ir
from hypgen.dsl.ir.inline import certain
from hypgen.dsl.ir.reward_scale import Ranges, largest_return, largest_reward
from hypgen.dsl.types import Float, length_of, size_of
from hypgen.dsl.types.intervals import Ends

_HALF = 2.0**-24  # of a float32: half of the place of its last bit
_FUNCTION = 2.0**-22  # of a function that is rounded from double
_TINY = 2.0**-149  # the least float32 above 0
_WORD = 2.0**-32  # the share of a random word
_SHORT = 1 << 12  # a constant of so coarse a grid is what its text says ..
_WHOLE = 1 << 24  # .. below this, where float32 has all whole numbers
_MASS = 2.0**-63  # the share of a mass
_NEAR_ONE = 1.0 - 2.0**-20  # a probability above it may have lost what it lacks to 1
_LAW = 2.0**-20  # of the laws of counts and of bins, whose masses are doubles of rounded parameters


class Rounding(NamedTuple):
    """Bounds of what is rounded; infinite where nothing limits what a step can earn.

    ``reward`` is of what a step earns. ``start`` and ``step`` are of the joint law of all that is drawn, as
    the sum of the differences of all probabilities; ``lost`` is the part of ``step`` that may be outcomes
    which are never drawn. ``largest`` and ``whole`` are the most that a step and an episode can earn.
    """

    reward: float
    start: float
    step: float
    lost: float
    largest: float
    whole: float


def rounding(model: ir.Model) -> Rounding:
    """Return how far the model is from its text."""
    errors = _Errors(model)
    reward = 0.0
    for term in model.rewards:
        members = 1 if term.binder is None else size_of(term.binder.type)
        found, size = errors.of(term.value, {}), errors.size(term.value, {})
        is_whole = not isinstance(term.value.type, Float) and model.reward_bits >= 0
        fixed = 0.0 if is_whole or size == 0.0 else 2.0 ** -(model.reward_bits + 1)
        reward += members * (found + fixed)
    steps = [(u.dist, length_of(tuple(b.type for b in u.binders))) for u in model.updates]
    steps += [(o.dist, length_of(tuple(b.type for b in o.binders))) for o in model.observations]
    steps += [(t.dist, 1 if t.binder is None else size_of(t.binder.type)) for t in model.lets]
    starts = [(i.dist, length_of(tuple(b.type for b in i.binders))) for i in model.inits]
    return Rounding(
        reward,
        sum(count * errors.of_law(dist, {}) for dist, count in starts),
        sum(count * errors.of_law(dist, {}) for dist, count in steps),
        sum(count * errors.lost(dist) for dist, count in steps),
        largest_reward(model),
        largest_return(model),
    )


class _Errors:
    """How far expressions are from what their text says; ``local`` has ranges and errors of locals."""

    def __init__(self, model: ir.Model) -> None:
        self._ranges = Ranges(model)
        self._params = {p.name: p for p in model.params}
        self._tables = {t.name: t for t in model.tables}
        self._lets = {let.name: let for let in model.all_lets}
        self._functions = {f.name: f for f in model.functions}

    def _ends(self, e: ir.Expr, local: Mapping[str, tuple[Ends, float]]) -> Ends:
        return self._ranges.of(e, {name: ends for name, (ends, _) in local.items()})

    def _width(self, e: ir.Expr, local: Mapping[str, tuple[Ends, float]]) -> float:
        low, high = self._ends(e, local)
        return high - low

    def size(self, e: ir.Expr, local: Mapping[str, tuple[Ends, float]]) -> float:
        """Return the largest size of a number."""
        return max(map(abs, self._ends(e, local)))

    def of(self, e: ir.Expr, local: Mapping[str, tuple[Ends, float]]) -> float:
        """Return a bound of the difference; 0 of what is no float."""
        if not isinstance(e.type, Float):
            return 0.0
        found = self._found(e, local)
        if found <= 1e-3 * self.size(e, local):
            return found
        return min(found, self._width(e, local) + _half(self.size(e, local)))

    def _found(self, e: ir.Expr, local: Mapping[str, tuple[Ends, float]]) -> float:
        size = self.size(e, local)
        match e:
            case ir.Const(value=value, exact=exact) if exact is not None:
                return float(abs(exact - Fraction(value))) * (1.0 + _HALF)
            case ir.Const(value=value) if float(value * _SHORT).is_integer() and abs(value) < _WHOLE:
                return 0.0  # a literal, which would have its exact number if it were rounded
            case ir.Const() | ir.ParamRead() | ir.TableRead():
                return _half(size)
            case ir.Local(name=name):
                return local[name][1] if name in local else 0.0
            case ir.ToFloat():
                return _half(size) if size > 1 << 24 else 0.0
            case ir.Unary(op="neg" | "abs", operand=operand):
                return self.of(operand, local)
            case ir.Unary(op=op, operand=operand):
                return _of_function(op, self._ends(operand, local), self.of(operand, local), size)
            case ir.Binary(op="pow", left=left, right=right):
                return self._of_power(left, right, local, size)
            case ir.Binary(op="hypot", left=left, right=right):
                return self.of(left, local) + self.of(right, local) + size * _FUNCTION + _TINY
            case ir.Binary(op="min" | "max", left=left, right=right):
                return max(self.of(left, local), self.of(right, local))
            case ir.Binary(op="add" | "sub", left=left, right=right):
                return self.of(left, local) + self.of(right, local) + _half(size)
            case ir.Binary(op="mul", left=left, right=right):
                a, b = self.of(left, local), self.of(right, local)
                return (
                    _times(self.size(left, local), b) + _times(self.size(right, local) + b, a) + _half(size)
                )
            case ir.Binary(op="div", left=left, right=right):
                low, high = self._ends(right, local)
                a, b = self.of(left, local), self.of(right, local)
                least = min(abs(low), abs(high)) - b if low * high > 0 else 0.0
                return math.inf if least <= 0 else (a + _times(size, b)) / least + _half(size)
            case ir.Clamp(operand=operand):
                return max(self.of(operand, local), _half(size))
            case ir.If(then=then, otherwise=otherwise):
                return max(self.of(then, local), self.of(otherwise, local))
            case ir.LetIn(name=name, value=value, body=body):
                return self.of(body, {**local, name: self._pair(value, local)})
            case ir.Call(function=name, arguments=arguments):
                function = self._functions[name]
                pairs = (self._pair(a, local) for a in arguments)
                names = (f.name for f in function.formals)
                return self.of(function.body, dict(zip(names, pairs, strict=True)))
            case ir.LetRead(let=name):
                body = certain(self._lets[name].dist)
                return 0.0 if body is None else self.of(body, {})
            case ir.Quantified(kind="sum", binders=binders, body=body) if body is not None:
                count = length_of(tuple(b.type for b in binders))
                return count * (self.of(body, local) + _half(count * self.size(body, local)))
            case ir.Quantified(kind="min" | "max", body=body, otherwise=other) if body is not None:
                return max(self.of(part, local) for part in (body, other) if part is not None)
            case ir.StateRead():
                return 0.0
        return self._width(e, local)

    def _of_power(
        self, left: ir.Expr, right: ir.Expr, local: Mapping[str, tuple[Ends, float]], size: float
    ) -> float:
        """Return how far a power may be: that of its logarithm, and the rounding of the function."""
        low, high = self._ends(left, local)
        a, b = self.of(left, local), self.of(right, local)
        if isinstance(right, ir.ToFloat) and low >= 0.0 and (most := self._ends(right, local)[1]) < 100.0:
            steep = most * max(1.0, high + a) ** max(0.0, most - 1.0)  # a whole power
            return _times(steep, a) + size * _FUNCTION + _TINY
        if low - a <= 0.0 or math.isinf(high):
            return math.inf if a or b else size * _FUNCTION + _TINY
        steep = max(abs(math.log(low - a)), abs(math.log(high + a)))
        power = self.size(right, local) + b
        return _grown(size, _times(steep, b) + _times(power, a / (low - a))) + size * _FUNCTION + _TINY

    def lost(self, dist: ir.Dist) -> float:
        """Return how likely the outcomes may be that a draw never has."""
        match dist:
            case ir.IfDist(then=then, otherwise=otherwise):
                return max(self.lost(then), self.lost(otherwise))
            case ir.LetDist(body=body):
                return self.lost(body)
            case ir.Widened(dist=inner):
                return self.lost(inner)
            case ir.Bernoulli(probability=p) | ir.Noisy(probability=p):
                probabilities = [p]
            case ir.Table(entries=entries):
                probabilities = [p for _, p in entries]
            case _:
                probabilities = []
        rounded = sum(2 * _HALF for p in probabilities if self._is_near_one(p))
        return 2 * _share(dist) * _outcomes(dist) + rounded

    def _is_near_one(self, p: ir.Expr) -> bool:
        if isinstance(p, ir.Const):
            return False  # a constant's mass is that of its text
        if isinstance(p, ir.ParamRead) and (default := self._params[p.param].default):
            return max(map(float, default)) > _NEAR_ONE
        if isinstance(p, ir.TableRead):
            return max(map(float, self._tables[p.table].values)) > _NEAR_ONE
        return not isinstance(p.type, Float) or p.type.high > _NEAR_ONE

    def _pair(self, e: ir.Expr, local: Mapping[str, tuple[Ends, float]]) -> tuple[Ends, float]:
        return self._ends(e, local), self.of(e, local)

    def of_law(self, dist: ir.Dist, local: Mapping[str, tuple[Ends, float]]) -> float:
        """Return a bound of the sum of the differences of all probabilities of a draw."""
        words = 2 * _share(dist) * _outcomes(dist)
        match dist:
            case ir.Certain():
                return 0.0
            case ir.Uniform():
                return 0.0 if size_of(dist.type).bit_count() == 1 else words
            case ir.UniformSet(otherwise=otherwise):
                return words + (0.0 if otherwise is None else self.of_law(otherwise, local))
            case ir.Bernoulli(probability=p) | ir.Noisy(probability=p):
                return 2 * self.of(p, local) + (
                    0.0 if _in_words(p) and isinstance(dist, ir.Bernoulli) else words
                )
            case ir.Table(entries=entries):
                found = sum(self.of(p, local) for _, p in entries)
                return 2 * found + (0.0 if all(_in_words(p) for _, p in entries) else words)
            case ir.Weighted(weight=weight, otherwise=otherwise):
                rest = 0.0 if otherwise is None else self.of_law(otherwise, local)
                is_leaf = isinstance(weight, ir.Const | ir.ParamRead | ir.TableRead)
                return words + 4 * _WORD + (2 * _HALF if is_leaf else _LAW) + rest
            case ir.IfDist(then=then, otherwise=otherwise):
                return max(self.of_law(then, local), self.of_law(otherwise, local))
            case ir.LetDist(name=name, value=value, body=body):
                return self.of_law(body, {**local, name: self._pair(value, local)})
            case ir.Widened(dist=inner):
                return self.of_law(inner, local)
        return words + _LAW


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


def _half(size: float) -> float:
    return size * _HALF + _TINY if size else 0.0


def _times(a: float, b: float) -> float:
    return a * b if a and b else 0.0


def _share(dist: ir.Dist) -> float:
    """Return the share of what a draw compares with: its probabilities are whole numbers of it."""
    return _MASS if isinstance(dist, ir.Bernoulli | ir.Noisy | ir.Table | ir.Weighted) else _WORD


def _in_words(p: ir.Expr) -> bool:
    return isinstance(p, ir.Const) and (float(p.value) / _MASS).is_integer()


def _outcomes(dist: ir.Dist) -> int:
    """Return how many values a draw may have at the most."""
    if isinstance(dist, ir.Certain):
        return 0
    if isinstance(dist, ir.Bernoulli):
        return 2
    if isinstance(dist, ir.Table):
        return len(dist.entries) + 1
    if isinstance(dist, ir.UniformSet | ir.Weighted):
        return length_of(tuple(b.type for b in dist.binders)) + _outcomes_of(dist.otherwise)
    if isinstance(dist, ir.IfDist):
        return max(_outcomes(dist.then), _outcomes(dist.otherwise))
    if isinstance(dist, ir.LetDist):
        return _outcomes(dist.body)
    return 0 if isinstance(dist.type, Float) else size_of(dist.type)


def _outcomes_of(dist: ir.Dist | None) -> int:
    return 0 if dist is None else _outcomes(dist)
