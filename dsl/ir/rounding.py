# SPDX-License-Identifier: Apache-2.0
"""How far a model's rewards and draws are from the real numbers of its text.

Rewards are in fixed point, and draws compare with whole numbers of 2^-32 or 2^-63.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from hypgen.dsl import ir
from hypgen.dsl.ir import masses
from hypgen.dsl.ir.expression_errors import ExpressionErrors, Local
from hypgen.dsl.ir.inline import certain
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.reward_scale import largest_return, largest_reward
from hypgen.dsl.types import Float, length_of, size_of
from hypgen.dsl.types.intervals import ESTIMATE, half_place

_WORD = 2.0**-32  # the share of a random word
_MASS = 2.0**-63  # the share of a mass
_HALF = 2.0**-24  # of a probability: half of its last place
_NEAR_ONE = 1.0 - 2.0**-20  # a probability above it may have lost what it lacks to 1
_LAW = ESTIMATE  # of the laws of counts and of bins, whose masses are doubles of rounded parameters


class Rounding(NamedTuple):
    """Bounds of what is rounded; infinite where nothing limits what a step can earn.

    ``reward`` is of what a step earns. ``start`` and ``step`` are of the joint law of all that is drawn, as
    the sum of the differences of all probabilities; ``lost`` is the part of ``step`` that may be outcomes
    which are never drawn. Besides, no probability of a step differs by more than ``relative`` of itself, but
    for parts that add up to ``rest``. ``drawn`` is the most that a step can earn in terms that read what it
    draws, ``whole`` the most that an episode can earn.
    """

    reward: float
    start: float
    step: float
    lost: float
    relative: float
    rest: float
    drawn: float
    whole: float


def with_any_params(model: ir.Model) -> ir.Model:
    """Return the model with params of which only the types are known, where these limit them.

    A param of any size counts with the numbers that the text declares.
    """
    params = []
    for p in model.params:
        if not isinstance(p.type, Float) or math.isinf(p.type.low) or math.isinf(p.type.high):
            most = max((abs(float(v)) for v in p.default or ()), default=0.0)
            params.append(replace(p, error=half_place(most) if isinstance(p.type, Float) else 0.0))
        else:
            most = max(abs(p.type.low), abs(p.type.high))
            params.append(replace(p, default=None, error=half_place(most)))
    return replace(model, params=tuple(params))


def rounding(model: ir.Model) -> Rounding:
    """Return how far the model is from its text, its params at what the text declares."""
    errors, laws = ExpressionErrors(model), _LawErrors(model)
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
    parts = [(count, *laws.relative(dist, {})) for dist, count in steps]
    lost = sum(count * laws.lost(dist) for dist, count in steps)
    return Rounding(
        reward,
        sum(count * laws.of_law(dist, {}) for dist, count in starts),
        sum(count * laws.of_law(dist, {}) for dist, count in steps),
        lost,
        math.expm1(sum(count * part for count, part, _ in parts)),
        lost + sum(count * rest for count, _, rest in parts),
        largest_reward(model, partial(_reads_draws, model=model)),
        largest_return(model),
    )


def _reads_draws(value: ir.Expr, model: ir.Model) -> bool:
    """Return whether a value may read what a step draws."""
    lets = {let.name: let for let in model.all_lets}
    return any(
        (isinstance(e, ir.StateRead) and (primed or e.primed))
        or (isinstance(e, ir.LetRead) and certain(lets[e.let].dist) is None)
        for e, primed in reached((value,), {f.name: f for f in model.functions}, lets)
    )


class _LawErrors:
    """How far draws are from what their text says."""

    def __init__(self, model: ir.Model) -> None:
        self._of = ExpressionErrors(model)
        self._params = {p.name: p for p in model.params}
        self._tables = {t.name: t for t in model.tables}

    def lost(self, dist: ir.Dist) -> float:
        """Return how likely the outcomes may be that a draw never has."""
        match dist:
            case ir.IfDist(then=then, otherwise=otherwise):
                return max(self.lost(then), self.lost(otherwise))
            case ir.LetDist(body=body):
                return self.lost(body)
            case ir.Widened(dist=inner) | ir.InVariant(dist=inner):
                return self.lost(inner)
            case ir.DrawIn(law=law, body=body):
                return self.lost(law) + self.lost(body)
            case ir.Certain() | ir.Uniform():
                return 0.0
            case ir.UniformSet(otherwise=otherwise):
                return 0.0 if otherwise is None else self.lost(otherwise)
            case ir.Bernoulli(probability=ir.Const() as p):
                return _lost(masses.of_constant(p), masses.number(p))
            case ir.Table() if (found := masses.of_table(dist)) is not None:
                return sum(map(_lost, found, _numbers(dist)))
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
            return False  # its mass is that of its text where float32 would lose what it lacks
        if isinstance(p, ir.ParamRead) and (default := self._params[p.param].default):
            return max(map(float, default)) > _NEAR_ONE
        if isinstance(p, ir.TableRead):
            return max(map(float, self._tables[p.table].values)) > _NEAR_ONE
        return not isinstance(p.type, Float) or p.type.high > _NEAR_ONE

    def relative(self, dist: ir.Dist, local: Local) -> tuple[float, float]:
        """Return how far probabilities are, for each unit of each, and what is not told so, as a sum."""
        words = 2 * _share(dist) * _outcomes(dist)
        match dist:
            case ir.Certain():
                return 0.0, 0.0
            case ir.Bernoulli(probability=ir.Const() as p):
                return _part(masses.of_constant(p), masses.number(p)), 0.0
            case ir.Table() if (found := masses.of_table(dist)) is not None:
                return max(map(_part, found, _numbers(dist))), 0.0
            case ir.Bernoulli(probability=p) | ir.Noisy(probability=p):
                return self._of_events([p], dist, local)
            case ir.Table(entries=entries, rest=rest):
                # The last takes what the others leave.
                return self._of_events([p for _, p in entries][: None if rest else -1], dist, local)
            case ir.Weighted(weight=ir.ParamRead() | ir.TableRead(), otherwise=otherwise):
                part, left = (0.0, 0.0) if otherwise is None else self.relative(otherwise, local)
                return max(part, 4 * _HALF), left + words + 4 * _WORD
            case ir.IfDist(then=then, otherwise=otherwise):
                a, b = self.relative(then, local), self.relative(otherwise, local)
                return max(a[0], b[0]), max(a[1], b[1])
            case ir.LetDist(name=name, value=value, body=body):
                return self.relative(body, {**local, name: self._of.pair(value, local)})
            case ir.DrawIn(law=law, body=body):
                a, b = self.relative(law, local), self.relative(body, local)
                return a[0] + b[0] + a[0] * b[0], a[1] + b[1]
            case ir.Widened(dist=inner) | ir.InVariant(dist=inner):
                return self.relative(inner, local)
        return 0.0, self.of_law(dist, local)

    def _of_events(self, given: list[ir.Expr], dist: ir.Dist, local: Local) -> tuple[float, float]:
        """Return the same of a draw with given probabilities, of which the rest takes what they leave."""
        off = sum(self._of.of(p, local) for p in given)
        least = 1.0 - sum(self._of.size(p, local) for p in given) - off
        of_rest = off / least if least > 0.0 else math.inf if off else 0.0
        part = max(of_rest, *(self._part(p, local) for p in given)) if given else of_rest
        if math.isinf(part):
            return 0.0, self.of_law(dist, local)
        return part, 2 * _share(dist) * _outcomes(dist)

    def _part(self, p: ir.Expr, local: Local) -> float:
        """Return how far a probability is, for each unit of it."""
        off = self._of.of(p, local)
        if off == 0.0 or isinstance(p, ir.Const | ir.ParamRead | ir.TableRead):
            return _HALF if off else 0.0
        low = self._of.ends(p, local)[0] - off
        return off / low if low > 0.0 else math.inf

    def of_law(self, dist: ir.Dist, local: Local) -> float:
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
                rest = words if isinstance(dist, ir.Noisy) else 0.0
                if isinstance(p, ir.Const):
                    return 2 * _off(masses.of_constant(p), masses.number(p)) + rest
                return 2 * self._of.of(p, local) + words
            case ir.Table(entries=entries):
                if (found := masses.of_table(dist)) is not None:
                    numbers = _numbers(dist)
                    off = sum(_off(mass, p) for mass, p in zip(found, numbers, strict=True))
                    return off + abs(float(1 - sum(numbers)))
                return 2 * sum(self._of.of(p, local) for _, p in entries) + words
            case ir.Weighted(weight=weight, otherwise=otherwise):
                rest = 0.0 if otherwise is None else self.of_law(otherwise, local)
                is_leaf = isinstance(weight, ir.Const | ir.ParamRead | ir.TableRead)
                return words + 4 * _WORD + (2 * _HALF if is_leaf else _LAW) + rest
            case ir.IfDist(then=then, otherwise=otherwise):
                return max(self.of_law(then, local), self.of_law(otherwise, local))
            case ir.LetDist(name=name, value=value, body=body):
                return self.of_law(body, {**local, name: self._of.pair(value, local)})
            case ir.DrawIn(law=law, body=body):
                return self.of_law(law, local) + self.of_law(body, local)
            case ir.Widened(dist=inner) | ir.InVariant(dist=inner):
                return self.of_law(inner, local)
        return words + _LAW


def _share(dist: ir.Dist) -> float:
    """Return the share of what a draw compares with: its probabilities are whole numbers of it."""
    return _MASS if isinstance(dist, ir.Bernoulli | ir.Noisy | ir.Table | ir.Weighted) else _WORD


def _off(mass: int, p: Fraction) -> float:
    """Return how far a mass is from the probability that the text says."""
    return abs(float(Fraction(mass, masses.WHOLE) - p))


def _lost(mass: int, p: Fraction) -> float:
    """Return how likely an outcome of an event, or of its opposite, is that is never drawn."""
    return float(p if mass == 0 else 1 - p if mass == masses.WHOLE else 0)


def _part(mass: int, p: Fraction) -> float:
    """Return how far a mass and what it lacks are, for each unit of the text's; 0 for what is never drawn."""
    own, other = Fraction(mass, masses.WHOLE), Fraction(masses.WHOLE - mass, masses.WHOLE)
    parts = ((own, p), (other, 1 - p))
    return float(max(abs(found - said) / said if found and said else Fraction(0) for found, said in parts))


def _numbers(dist: ir.Table) -> list[Fraction]:
    """Return the text's probabilities of a table of constants, what the others leave last."""
    numbers = [masses.number(p) for _, p in dist.entries if isinstance(p, ir.Const)]
    return numbers if dist.rest is None else [*numbers, max(1 - sum(numbers, Fraction(0)), Fraction(0))]


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
