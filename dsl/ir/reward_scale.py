# SPDX-License-Identifier: Apache-2.0
"""The scale of a model's rewards: how many fraction bits they have in fixed point.

Rewards and bounds are 64-bit integers that stand for multiples of a power of two. Sums over 2^14 scenarios
have to fit, so one value has 48 bits. What a model can earn at the most decides what they are worth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.ir.inline import certain
from hypgen.dsl.types import Float, Int, Type, intervals, length_of, low_of, size_of
from hypgen.dsl.types.intervals import Ends

VALUE_BITS = 48  # of a value, beside its sign
LARGEST_FLOAT = 2.0**128
# An episode of a model without discount and horizon is taken to earn so often at the most.
_UNDISCOUNTED_STEPS = 1024

_OPERATORS = {"add": intervals.add, "sub": intervals.sub, "mul": intervals.mul, "div": intervals.div}


def reward_bits(model: ir.Model) -> int:
    """Return the number of fraction bits of the model's rewards; below 0: the last bit is above 1.

    The most that an episode can earn fits. Of the most that a step can earn 24 bits or more are kept, where
    that leaves room. Rewards without a range keep ``REWARD_BITS``: a step beyond what fits is a model error.
    """
    step, whole = largest_reward(model), largest_return(model)
    if not 0.0 < step < math.inf or not whole < LARGEST_FLOAT:
        return ir.REWARD_BITS
    if step >= 1.0 and whole < 2.0 ** (VALUE_BITS - ir.REWARD_BITS):
        return ir.REWARD_BITS
    room = VALUE_BITS - math.frexp(whole)[1]
    return min(room, ir.REWARD_BITS + max(0, 1 - math.frexp(step)[1]))


def rewards_fit(model: ir.Model, bits: int) -> bool:
    """Return whether no step's sum of rewards leaves its range, whatever the params are."""
    any_params = replace(model, params=tuple(replace(p, default=None) for p in model.params))
    largest = _sum_of_terms(model.rewards, _SureRanges(any_params))
    return largest < math.ldexp(1.0, VALUE_BITS - 1 - bits)


def largest_reward(model: ir.Model, counts: Callable[[ir.Expr], bool] = lambda value: True) -> float:
    """Return the sum of the most that each reward term can earn or cost, params at their declared values.

    ``counts`` chooses terms.
    """
    return _sum_of_terms(filter(lambda term: counts(term.value), model.rewards), Ranges(model))


def _sum_of_terms(terms: Iterable[ir.Reward], ranges: Ranges) -> float:
    total = 0.0
    for term in terms:
        members = 1 if term.binder is None else size_of(term.binder.type)
        total += members * max(map(abs, ranges.of(term.value, {})))
    return total


def largest_return(model: ir.Model) -> float:
    """Return the most that the rewards of an episode can add up to."""
    step = largest_reward(model)
    steps = math.inf if model.horizon is None else model.horizon
    if model.discount < 1.0:
        steps = min(steps, 1.0 / (1.0 - model.discount))
    if math.isfinite(steps) or step == 0.0:
        return step * steps if step else 0.0
    ends = [abs(end) for e in (model.upper, model.tail, model.lower) if e for end in _of_type(e.type)]
    return max(step * _UNDISCOUNTED_STEPS, *(end for end in ends if math.isfinite(end)), 0.0)


class Ranges:
    """The ranges of expressions: where a type has none, that of what params are declared as."""

    def __init__(self, model: ir.Model) -> None:
        self._params = {p.name: p for p in model.params}
        self._lets = {let.name: let for let in model.all_lets}
        self._functions = {f.name: f for f in model.functions}

    def of(self, e: ir.Expr, local: Mapping[str, Ends]) -> Ends:
        """Return the range of a number or a bool, given those of locals."""
        low, high = _of_type(e.type)
        if math.isfinite(low) and math.isfinite(high):
            return low, high
        found = self._found(e, local)
        return max(low, found[0]), min(high, found[1])

    def _found(self, e: ir.Expr, local: Mapping[str, Ends]) -> Ends:
        match e:
            case ir.Local(name=name) if name in local:
                return local[name]
            case ir.ParamRead(param=name) if self._params[name].default:
                return intervals.hull(float(value) for value in self._params[name].default or ())
            case ir.ToFloat(operand=operand):
                return self.of(operand, local)
            case ir.Unary(op="neg", operand=operand):
                low, high = self.of(operand, local)
                return -high, -low
            case ir.Unary(op="abs", operand=operand):
                low, high = self.of(operand, local)
                return 0.0, max(abs(low), abs(high))
            case ir.Binary(op=op, left=left, right=right):
                return _operated(op, self.of(left, local), self.of(right, local))
            case ir.If(then=then, otherwise=otherwise):
                return _joined(self.of(part, local) for part in (then, otherwise))
            case ir.LetIn(name=name, value=value, body=body):
                return self.of(body, {**local, name: self.of(value, local)})
            case ir.Call(function=name, arguments=arguments):
                function = self._functions[name]
                given = (self.of(a, local) for a in arguments)
                names = (f.name for f in function.formals)
                return self.of(function.body, dict(zip(names, given, strict=True)))
            case ir.LetRead(let=name) if (body := certain(self._lets[name].dist)) is not None:
                return self.of(body, {})
            case ir.Quantified(kind="sum", binders=binders, body=body) if body is not None:
                low, high = self.of(body, local)
                count = length_of(tuple(b.type for b in binders))
                return count * min(low, 0.0), count * max(high, 0.0)
            case ir.Quantified(kind="min" | "max", body=body, otherwise=other) if body is not None:
                return _joined(self.of(part, local) for part in (body, other) if part is not None)
        return _of_type(e.type)


class _SureRanges(Ranges):
    """Ranges that no value leaves: computed in float32, and not taken from what a probability is to be.

    A function may compute a ``prob`` from params. Only params, constants and what is clamped are checked.
    """

    def of(self, e: ir.Expr, local: Mapping[str, Ends]) -> Ends:
        """Return the range of a number or a bool, given those of locals."""
        is_checked = isinstance(e, ir.Const | ir.ParamRead | ir.Clamp | ir.Checked)
        if not isinstance(e.type, Float) or (is_checked and e.type.prob):
            return super().of(e, local)
        if not e.type.prob:
            return intervals.rounded(super().of(e, local))
        is_computed = isinstance(e, ir.Unary | ir.Binary | ir.If | ir.LetIn | ir.Call | ir.ToFloat)
        if is_computed or (isinstance(e, ir.Local) and e.name in local):
            return intervals.rounded(self._found(e, local))
        return -math.inf, math.inf


def _of_type(t: Type) -> Ends:
    if isinstance(t, Int | Float):
        return float(t.low), float(t.high)
    low = low_of(t)
    return float(low), float(low + size_of(t) - 1)


def _operated(op: str, a: Ends, b: Ends) -> Ends:
    match op:
        case "min":
            return min(a[0], b[0]), min(a[1], b[1])
        case "max":
            return max(a[0], b[0]), max(a[1], b[1])
        case "pow":
            return intervals.power(a, b)
        case "hypot":
            return intervals.hypotenuse(a, b)
    return _OPERATORS[op](a, b) if op in _OPERATORS else (-math.inf, math.inf)


def _joined(parts: Iterable[Ends]) -> Ends:
    ends = list(parts)
    return min(low for low, _ in ends), max(high for _, high in ends)
