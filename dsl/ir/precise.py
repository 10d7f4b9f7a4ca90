# SPDX-License-Identifier: Apache-2.0
"""Draws with the text's own probabilities, for programs that have time for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import count, product
from math import prod
from typing import TypeVar

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.evaluate import Value, decided, value_at
from hypgen.dsl.ir.walk import Node, children, free_locals, map_children, negated
from hypgen.dsl.types import Int, Type, is_finite, low_of, size_of

Part = TypeVar("Part", ir.Assign, ir.Observation, ir.Let)
_MOST_ENTRIES = 1024  # probabilities that one draw is written out with
_MOST_CASES = 64  # of a key that has no order


def with_precise_draws(model: ir.Model) -> ir.Model:
    """Return the model with constant probabilities that have the masses of their texts, to 2^-64.

    A draw that reads its probabilities from constant arrays becomes a choice among draws with constants. An
    online planner draws with masses of float32 where these are nearly the same: one 32-bit word then decides.
    """
    precise = _Precise(model)
    return replace(
        model,
        updates=tuple(map(precise.part, model.updates)),
        inits=tuple(map(precise.part, model.inits)),
        observations=tuple(map(precise.part, model.observations)),
        lets=tuple(map(precise.part, model.lets)),
    )


@dataclass(frozen=True)
class _Scope:
    """What encloses a draw: locals with what they stand for, and what holds there."""

    lets: Mapping[str, ir.Expr] = field(default_factory=dict)
    holds: tuple[ir.Expr, ...] = ()


class _Precise:
    """Draws of a model with the text's own probabilities."""

    def __init__(self, model: ir.Model) -> None:
        self._arrays = {t.name: t for t in model.tables}
        self._numbers = count(1)

    def part(self, part: Part) -> Part:
        return replace(part, dist=self._draw(part.dist, _Scope()))

    def _draw(self, dist: ir.Dist, scope: _Scope) -> ir.Dist:
        match dist:
            case ir.LetDist(name=name, value=value, body=body):
                return replace(dist, body=self._draw(body, replace(scope, lets={**scope.lets, name: value})))
            case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
                yes = replace(scope, holds=(*scope.holds, condition))
                no = replace(scope, holds=(*scope.holds, negated(condition)))
                return replace(dist, then=self._draw(then, yes), otherwise=self._draw(otherwise, no))
            case ir.Bernoulli(probability=p) | ir.Noisy(probability=p):
                probabilities = [p]
            case ir.Table(entries=entries):
                probabilities = [p for _, p in entries]
            case ir.Weighted(weight=weight, condition=None, type=t) if t == dist.binders[0].type:
                return self._by_key(dist, [weight], scope) or dist
            case _:
                return map_children(dist, lambda c: self._draw(c, scope) if isinstance(c, ir.Dist) else c)
        if all(isinstance(p, ir.Const) for p in probabilities):
            return _with(dist, probabilities)
        return self._by_key(dist, probabilities, scope) or dist

    def _by_key(self, dist: ir.Dist, probabilities: Sequence[ir.Expr], scope: _Scope) -> ir.Dist | None:
        """Return a draw as a choice by what the places of its probabilities in arrays depend on.

        None where the numbers of a text are not known, or too many.
        """
        bound = {b.name for b in dist.binders} if isinstance(dist, ir.Weighted) else set()
        lets = dict(scope.lets)
        new: dict[str, ir.Expr] = {}
        keys: dict[str, ir.Local] = {}

        def add_keys(place: ir.Expr) -> None:
            for local in _locals(place):
                meaning = lets.get(local.name)
                if meaning is not None and _is_of_locals(meaning):
                    add_keys(meaning)
                elif local.name not in bound:
                    keys[local.name] = local

        def keyed(place: ir.Expr) -> ir.Expr:
            if not _is_of_locals(place):
                name = next((name for name, known in new.items() if known == place), None)
                name = name or f"place%{next(self._numbers)}"
                lets[name] = new[name] = place
                place = ir.Local(place.type, name)
            add_keys(place)
            return place

        read: list[ir.Expr] = []
        for p in probabilities:
            if isinstance(p, ir.TableRead) and self._arrays[p.table].exact is not None:
                read.append(replace(p, indices=tuple(map(keyed, p.indices))))
            elif isinstance(p, ir.Const):
                read.append(p)
            else:
                return None
        if any(bound & free_locals(place) for place in new.values()):
            return None
        domains = [self._values(lets.get(name, key), key.type) for name, key in keys.items()]
        values = [domain for domain in domains if domain is not None]
        width = len(probabilities) * prod(size_of(b.type) for b in getattr(dist, "binders", ()))
        if len(values) < len(domains) or width * prod(map(len, values)) > _MOST_ENTRIES:
            return None
        unordered = [v for k, v in zip(keys.values(), values, strict=True) if not isinstance(k.type, Int)]
        if any(len(v) > _MOST_CASES for v in unordered):
            return None
        found: dict[tuple[Value, ...], ir.Dist] = {}
        for chosen in product(*values):
            known = _Known(self._arrays, lets, dict(zip(keys, chosen, strict=True)))
            if any(known.value(condition) is False for condition in scope.holds):
                continue
            draw = _weighted(dist, read[0], known) if bound else _at(dist, read, known)
            if draw is None:
                return None
            found[chosen] = draw
        if not found:
            return None
        result = _chosen(found, list(keys.values()))
        for name, place in new.items():
            result = ir.LetDist(dist.type, name, place, result)
        return result

    def _values(self, e: ir.Expr, within: Type) -> Sequence[Value] | None:
        """Return the values that ``e`` may have, as far as they are ``within`` a type, ascending.

        None where they are not finitely many.
        """
        if not is_finite(e.type):
            return None
        if isinstance(e, ir.TableRead):
            return _within(sorted(set(self._arrays[e.table].values)), within)
        if size_of(e.type) > _MOST_ENTRIES:
            return None
        return _within([value_at(e.type, number) for number in range(size_of(e.type))], within)


@dataclass(frozen=True)
class _Known:
    """Values of keys, and of what is computed from them."""

    arrays: Mapping[str, ir.ConstantArray]
    lets: Mapping[str, ir.Expr]
    keys: Mapping[str, Value]

    def value(self, e: ir.Expr) -> Value | None:
        """Return the value of ``e``, None where the keys do not tell it."""
        return decided(self._folded(e), lambda _: None)

    def number(self, p: ir.Expr) -> Fraction | None:
        """Return the text's number of a probability; None where the keys do not tell it."""
        if isinstance(p, ir.Const):
            return Fraction(p.value) if p.exact is None else p.exact
        assert isinstance(p, ir.TableRead)
        exact, at = self.arrays[p.table].exact, self._place(p)
        return None if exact is None or at is None else exact[at]

    def _folded(self, e: ir.Expr) -> ir.Expr:
        if isinstance(e, ir.Local) and e.name in self.keys:
            return ir.Const(e.type, self.keys[e.name])
        if isinstance(e, ir.Local) and e.name in self.lets:
            return self._folded(self.lets[e.name])
        if isinstance(e, ir.TableRead):
            at = self._place(e)
            return e if at is None else ir.Const(e.type, self.arrays[e.table].values[at])
        return map_children(e, lambda c: self._folded(c) if isinstance(c, ir.Expr) else c)

    def _place(self, e: ir.TableRead) -> int | None:
        at = 0
        for index, place in zip(self.arrays[e.table].indices, e.indices, strict=True):
            value = self.value(place)
            if value is None or not 0 <= int(value) - low_of(index) < size_of(index):
                return None
            at = at * size_of(index) + int(value) - low_of(index)
        return at


def _at(dist: ir.Dist, probabilities: Sequence[ir.Expr], known: _Known) -> ir.Dist | None:
    numbers = [known.number(p) for p in probabilities]
    return None if None in numbers else _with(dist, [_exactly(n) for n in numbers if n is not None])


def _weighted(dist: ir.Dist, weight: ir.Expr, known: _Known) -> ir.Dist | None:
    assert isinstance(dist, ir.Weighted)
    [binder] = dist.binders
    options = [value_at(binder.type, number) for number in range(size_of(binder.type))]
    weights = [replace(known, keys={**known.keys, binder.name: o}).number(weight) for o in options]
    numbers = [w for w in weights if w is not None]
    if len(numbers) < len(weights):
        return None
    total = sum(w for w in numbers if w > 0)
    if total == 0:
        return dist.otherwise or ir.Certain(dist.type, operators.from_index(dist.type, 0))
    entries = tuple(
        (operators.from_index(dist.type, number), _exactly(weight / total))
        for number, weight in enumerate(numbers)
        if weight > 0
    )
    return _with(ir.Table(dist.type, entries, None), [p for _, p in entries])


def _within(values: Sequence[Value], t: Type) -> Sequence[Value]:
    """Return those of the values that the type has: what a condition has shown of a local."""
    return [value for value in values if t.low <= value <= t.high] if isinstance(t, Int) else values


def _is_of_locals(e: Node) -> bool:
    """Return whether ``e`` is computed from locals, constants and constant arrays alone."""
    plain = ir.Const | ir.Local | ir.TableRead | ir.Unary | ir.Binary | ir.Clamp
    return isinstance(e, plain) and all(map(_is_of_locals, children(e)))


def _locals(e: Node) -> list[ir.Local]:
    return [e] if isinstance(e, ir.Local) else [found for child in children(e) for found in _locals(child)]


def _exactly(p: Fraction) -> ir.Const:
    return operators.real(float(p), exact=p)


def _with(dist: ir.Dist, probabilities: Sequence[ir.Expr]) -> ir.Dist:
    """Return a draw with these constants for its probabilities."""
    precise = [replace(p, precise=True) for p in probabilities if isinstance(p, ir.Const)]
    if isinstance(dist, ir.Table):
        values = [value for value, _ in dist.entries]
        return replace(dist, entries=tuple(zip(values, precise, strict=True)), complements=())
    assert isinstance(dist, ir.Bernoulli | ir.Noisy)
    return replace(dist, probability=precise[0], complement=None)


def _chosen(draws: Mapping[tuple[Value, ...], ir.Dist], keys: Sequence[ir.Local]) -> ir.Dist:
    """Return the draw for the values of ``keys``."""
    if not keys:
        return draws[()]
    values = sorted({chosen[0] for chosen in draws})
    parts = [
        _chosen({chosen[1:]: draw for chosen, draw in draws.items() if chosen[0] == value}, keys[1:])
        for value in values
    ]
    return _by_order(parts, values, keys[0])


def _by_order(parts: Sequence[ir.Dist], values: Sequence[Value], key: ir.Local) -> ir.Dist:
    """Return the part whose value ``key`` has."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    if isinstance(key.type, Int):
        is_low = operators.compare("lt", key, operators.constant(key.type, values[half]))
    else:
        half = 1
        is_low = operators.compare("eq", key, operators.constant(key.type, values[0]))
    low, high = (_by_order(parts[part], values[part], key) for part in (slice(half), slice(half, None)))
    if operators.is_true(is_low) or operators.is_false(is_low):
        return low if operators.is_true(is_low) else high
    return ir.IfDist(low.type, is_low, low, high)
