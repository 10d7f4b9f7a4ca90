# SPDX-License-Identifier: Apache-2.0
"""Distributions of the IR: a draw from random bits, and the density of a value, in each lane.

Densities are doubles. Of a finite value they count the masses that give it, so that sampler and filter agree
exactly; of a continuous law they are per unit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.continuous import ContinuousLaws
from hypgen.dsl.interpret.evaluate.masses import Masses
from hypgen.dsl.interpret.evaluate.values import Array, Frame, Word, as_type, combinations, from_position
from hypgen.dsl.interpret.floats.scalar_functions import WHOLE, after, part, share_of
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.types import Int, low_of, size_of

_SHIFT = np.uint64(32)
_WORD = np.uint64(31)  # bits of a mass that lie below a word
_WEIGHED = 2.0**63 * (1 - 2.0**-32)  # the mass of all weights; what is left goes to the likeliest
_LEAST_PART = np.uint64(2**45)  # of what another than a noisy value gets by words alone

_DRAWN = "drawn%"  # what a variant is made of, or a variant that was drawn


class Evaluator(ContinuousLaws, Masses):
    """The values of a model's expressions, and the draws and densities of its distributions."""

    def sample(self, dist: ir.Dist, frame: Frame, word: Word) -> Array:
        """Return a draw from the distribution in each lane."""
        match dist:
            case ir.Certain():
                return self.value(dist.value, frame)
            case ir.Bernoulli():
                return word.below(self.mass(dist.probability, dist.complement, frame))
            case ir.Uniform():
                return from_position(
                    (word() * np.uint64(size_of(dist.type)) >> _SHIFT).astype(np.int64), dist.type
                )
            case ir.UniformSet():
                return self._sample_set(dist, frame, word)
            case ir.Table():
                return self._sample_table(dist, frame, word)
            case ir.Noisy():
                return self._sample_noisy(dist, frame, word)
            case ir.UniformInt():
                return self._sample_int(dist, frame, word)
            case ir.Counted():
                return self.sample_count(dist, frame, word)
            case ir.Weighted():
                return self._sample_weighted(dist, frame, word)
            case ir.Continuous():
                return self.sample_continuous(dist, frame, word)
            case ir.Binned():
                return self.sample_bin(dist, frame, word)
            case ir.Widened():
                return self.sample(dist.dist, frame, word)
            case ir.InVariant():
                drawn = frame.bind({_DRAWN: self.sample(dist.dist, frame, word)})
                return self.value(dist.made_of(ir.Local(dist.dist.type, _DRAWN)), drawn)
            case ir.DrawIn(name=name, law=law, body=body):
                drawn = frame.bind({name: self.sample(law, frame, word)})
                return self.sample(body, drawn, word.behind(words_of(law)))
            case ir.IfDist():
                return self._choose(dist, frame, lambda branch: self.sample(branch, frame, word))
            case ir.LetDist():
                return self.sample(dist.body, frame.bind({dist.name: self.value(dist.value, frame)}), word)
        raise TypeError(f"unknown distribution {type(dist).__name__}")

    def density(self, dist: ir.Dist, frame: Frame, value: Array) -> Array:
        """Return, as float64, the density of ``value`` in each lane: of a finite one its probability."""
        match dist:
            case ir.Certain():
                return np.where(self.value(dist.value, frame) == value, 1.0, 0.0)
            case ir.Bernoulli():
                mass = self.mass(dist.probability, dist.complement, frame)
                return share_of(np.where(value, mass, WHOLE - mass))
            case ir.Uniform():
                return np.asarray(1.0 / size_of(dist.type))
            case ir.UniformSet():
                return self._density_of_set(dist, frame, value)
            case ir.Table():
                return self._density_of_table(dist, frame, value)
            case ir.Noisy():
                return self._density_of_noisy(dist, frame, value)
            case ir.UniformInt():
                return self._density_of_int(dist, frame, value)
            case ir.Counted():
                return self.density_of_count(dist, frame, value)
            case ir.Weighted():
                return self._density_of_weighted(dist, frame, value)
            case ir.Continuous():
                return self.density_of_law(dist, frame, value)
            case ir.Binned():
                return self.density_of_bin(dist, frame, value)
            case ir.Widened():
                assert isinstance(dist.dist.type, Int)
                inside = (value >= dist.dist.type.low) & (value <= dist.dist.type.high)
                return np.where(inside, self.density(dist.dist, frame, value), 0.0)
            case ir.InVariant():
                held, given = ir.Local(dist.type, _DRAWN), frame.bind({_DRAWN: value})
                argument = self.value(dist.argument_of(held), given)
                return np.where(
                    self.value(dist.is_made(held), given), self.density(dist.dist, frame, argument), 0.0
                )
            case ir.DrawIn():
                return self._density_of_two(dist, frame, value)
            case ir.IfDist():
                return self._choose(dist, frame, lambda branch: self.density(branch, frame, value))
            case ir.LetDist():
                return self.density(dist.body, frame.bind({dist.name: self.value(dist.value, frame)}), value)
        raise TypeError(f"unknown distribution {type(dist).__name__}")

    def _choose(self, dist: ir.IfDist, frame: Frame, evaluate: Callable[[ir.Dist], Array]) -> Array:
        condition = self.value(dist.condition, frame)
        if condition.ndim == 0:
            return evaluate(dist.then if condition else dist.otherwise)
        return np.where(condition, evaluate(dist.then), evaluate(dist.otherwise))

    def _density_of_two(self, dist: ir.DrawIn, frame: Frame, value: Array) -> Array:
        total: Array = np.zeros(())
        for _, _, drawn in combinations((ir.Binder(dist.name, dist.law.type),)):
            chance = self.density(dist.law, frame, drawn[dist.name])
            if np.any(chance > 0.0):
                share = chance * self.density(dist.body, frame.bind(drawn), value)
                total = np.where(chance > 0.0, total + share, total)
        return total

    # Sets ------------------------------------------------------------------------------------

    def _members(self, dist: ir.UniformSet, frame: Frame) -> list[tuple[Array, Array]]:
        """Return, for each combination of the binders, where it belongs to the set, and its value."""
        frames = [frame.bind(values) for _, _, values in combinations(dist.binders)]
        return [(self.holds(dist.condition, f), self.value(dist.value, f)) for f in frames]

    def _sample_set(self, dist: ir.UniformSet, frame: Frame, word: Word) -> Array:
        members = self._members(dist, frame)
        count: Any = sum(match.astype(np.int64) for match, _ in members)
        chosen = (word() * count.astype(np.uint64) >> _SHIFT).astype(np.int64)
        result = members[0][1]
        seen: Any = np.int64(0)
        for match, value in members:
            result = np.where(match & (seen == chosen), value, result)
            seen = seen + match
        if dist.otherwise is not None:
            result = np.where(count == 0, self.sample(dist.otherwise, frame, word), result)
        return as_type(result, dist.type)

    def _density_of_set(self, dist: ir.UniformSet, frame: Frame, value: Array) -> Array:
        members = self._members(dist, frame)
        count: Any = sum(match.astype(np.int64) for match, _ in members)
        equal: Any = sum((match & (v == value)).astype(np.int64) for match, v in members)
        share = equal.astype(np.float64) / np.maximum(count, 1).astype(np.float64)
        if dist.otherwise is not None:
            empty = self.density(dist.otherwise, frame, value)
        else:
            empty = np.where(members[0][1] == value, 1.0, 0.0)
        return np.where(count == 0, empty, share)

    # Ranges and weights ------------------------------------------------------------------------

    def _int_ends(self, dist: ir.UniformInt, frame: Frame) -> tuple[Array, Array]:
        """Return the lowest int and how many there are."""
        low, high = (self.value(e, frame).astype(np.int64) for e in (dist.low, dist.high))
        return low, np.maximum(high - low + 1, 1)

    def _sample_int(self, dist: ir.UniformInt, frame: Frame, word: Word) -> Array:
        assert isinstance(dist.type, Int)
        low, count = self._int_ends(dist, frame)
        drawn = low + (word() * count.astype(np.uint64) >> _SHIFT).astype(np.int64)
        return as_type(np.clip(drawn, dist.type.low, dist.type.high), dist.type)

    def _density_of_int(self, dist: ir.UniformInt, frame: Frame, value: Array) -> Array:
        assert isinstance(dist.type, Int)
        low, count = self._int_ends(dist, frame)
        # An end of the type stands for all ints beyond it too.
        first = np.where(value == dist.type.low, low, np.maximum(low, value))
        last = np.where(value == dist.type.high, low + count - 1, np.minimum(low + count - 1, value))
        return np.asarray(np.maximum(last - first + 1, 0).astype(np.float64) / count.astype(np.float64))

    def _weights(
        self, dist: ir.Weighted, frame: Frame
    ) -> tuple[list[tuple[Array, Array, Array]], Array, Array]:
        """Return the binder's values, where each can be drawn, with its mass; their sum; the likeliest."""
        found = []
        total: Array = np.zeros(())
        largest: Array = np.zeros((), dtype=np.float32)
        likeliest: Array | None = None
        for _, _, values in combinations(dist.binders):
            inner = frame.bind(values)
            weight = self.value(dist.weight, inner)
            match = self.holds(dist.condition, inner) & (weight > 0.0)
            total = np.where(match, total + weight.astype(np.float64), total)
            value = values[dist.binders[0].name]
            likeliest = value if likeliest is None else np.where(match & (weight > largest), value, likeliest)
            largest = np.where(match & (weight > largest), weight, largest)
            found.append((value, match, weight))
        assert likeliest is not None
        with np.errstate(all="ignore"):
            scale = _WEIGHED / total
            return [(v, match, part(w, scale)) for v, match, w in found], total, likeliest

    def _sample_weighted(self, dist: ir.Weighted, frame: Frame, word: Word) -> Array:
        found, total, result = self._weights(dist, frame)
        until: Any = np.uint64(0)
        taken: Any = np.zeros((), dtype=np.bool_)
        for value, match, mass in found:
            until = np.where(match, after(until, mass), until)
            take = ~taken & match & word.below(until)
            result = np.where(take, value, result)
            taken = taken | take
        if dist.otherwise is not None:
            result = np.where(total > 0.0, result, self.sample(dist.otherwise, frame, word))
        return as_type(result, dist.type)

    def _density_of_weighted(self, dist: ir.Weighted, frame: Frame, value: Array) -> Array:
        found, total, likeliest = self._weights(dist, frame)
        until: Any = np.uint64(0)
        masses: Any = np.uint64(0)
        for candidate, match, mass in found:
            end = np.where(match, after(until, mass), until)
            masses = np.where(candidate == value, masses + (end - until), masses)
            until = end
        masses = np.where(likeliest == value, masses + (WHOLE - until), masses)
        if dist.otherwise is not None:
            empty = self.density(dist.otherwise, frame, value)
        else:
            empty = np.where(found[0][0] == value, 1.0, 0.0)
        return np.where(total > 0.0, share_of(masses), empty)

    # Tables ----------------------------------------------------------------------------------

    def _sample_table(self, dist: ir.Table, frame: Frame, word: Word) -> Array:
        values = [self.value(v, frame) for v, _ in dist.entries]
        result = values[-1] if dist.rest is None else self.value(dist.rest, frame)
        until: Any = np.uint64(0)
        taken: Any = np.zeros((), dtype=np.bool_)
        for value, mass in zip(values, self.masses(dist, frame), strict=False):
            until = after(until, mass)
            take = ~taken & word.below(until)
            result = np.where(take, value, result)
            taken = taken | take
        shape = np.broadcast_shapes(np.shape(result), word().shape)
        return as_type(np.broadcast_to(result, shape), dist.type)

    def _density_of_table(self, dist: ir.Table, frame: Frame, value: Array) -> Array:
        masses: Array = np.zeros((), dtype=np.uint64)
        until: Array = np.zeros((), dtype=np.uint64)
        values = [self.value(v, frame) for v, _ in dist.entries]
        for entry, mass in zip(values, self.masses(dist, frame), strict=False):
            end = after(until, mass)
            masses = np.where(entry == value, masses + (end - until), masses)
            until = end
        rest = values[-1] if dist.rest is None else self.value(dist.rest, frame)
        return share_of(np.where(rest == value, masses + (WHOLE - until), masses))

    # Noisy values ----------------------------------------------------------------------------

    def _sample_noisy(self, dist: ir.Noisy, frame: Frame, word: Word) -> Array:
        exact = self.value(dist.value, frame)
        others = size_of(dist.type) - 1
        if others == 0:
            return exact
        mass = self.mass(dist.probability, dist.complement, frame)
        other = self._other(word, mass, np.uint64(others)).astype(np.int64)
        position = exact.astype(np.int64) - low_of(dist.type)
        other = other + (other >= position)
        return as_type(np.where(word.below(mass), exact, from_position(other, dist.type)), dist.type)

    @staticmethod
    def _other(word: Word, mass: Array, others: np.uint64) -> Array:
        """Return which of the others is drawn in lanes where the value is not."""
        room = WHOLE - mass
        by_words = (mass & np.uint64(2**31 - 1) == 0) & (room >= others * _LEAST_PART)
        draw, first = word(), mass >> _WORD
        beyond = np.where(draw < first, np.uint64(0), draw - first)
        result: Array = beyond * others // np.maximum(room >> _WORD, np.uint64(1))
        if np.all(by_words):
            return result
        whole = word.whole()
        beyond = np.where(whole < mass, np.uint64(0), whole - mass)
        size, larger = room // others, room % others
        after_larger = beyond - np.minimum(beyond, larger * (size + np.uint64(1)))
        by_parts = np.where(
            beyond < larger * (size + np.uint64(1)),
            beyond // (size + np.uint64(1)),
            larger + after_larger // np.maximum(size, np.uint64(1)),
        )
        return np.where(by_words, result, by_parts)

    def _density_of_noisy(self, dist: ir.Noisy, frame: Frame, value: Array) -> Array:
        exact = self.value(dist.value, frame)
        size = size_of(dist.type)
        if size == 1:
            return np.where(exact == value, 1.0, 0.0)
        mass = self.mass(dist.probability, dist.complement, frame)
        return np.where(exact == value, share_of(mass), share_of(WHOLE - mass) / (size - 1))
