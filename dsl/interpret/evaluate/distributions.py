# SPDX-License-Identifier: Apache-2.0
"""Distributions of the IR: a draw from one 32-bit word, and the density of a value, in each lane.

Densities are doubles that count the words which give a value, so that sampler and filter agree exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.continuous import ContinuousLaws
from hypgen.dsl.interpret.evaluate.counts import share, words_of
from hypgen.dsl.interpret.evaluate.values import Array, Frame, Word, as_type, combinations, from_position
from hypgen.dsl.interpret.floats.scalar_functions import threshold
from hypgen.dsl.types import Int, low_of, size_of

_SHIFT = np.uint64(32)
_RANGE = np.uint64(2**32)


class Evaluator(ContinuousLaws):
    """The values of a model's expressions, and the draws and densities of its distributions."""

    def sample(self, dist: ir.Dist, frame: Frame, word: Word) -> Array:
        """Return a draw from the distribution in each lane."""
        match dist:
            case ir.Certain():
                return self.value(dist.value, frame)
            case ir.Bernoulli():
                return np.asarray(word() < threshold(self.value(dist.probability, frame)))
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
            case ir.IfDist():
                return self._choose(dist, frame, lambda branch: self.sample(branch, frame, word))
            case ir.LetDist():
                return self.sample(dist.body, frame.bind({dist.name: self.value(dist.value, frame)}), word)
        raise TypeError(f"unknown distribution {type(dist).__name__}")

    def density(self, dist: ir.Dist, frame: Frame, value: Array) -> Array:
        """Return, as float64, the probability of ``value`` in each lane."""
        match dist:
            case ir.Certain():
                return np.where(self.value(dist.value, frame) == value, 1.0, 0.0)
            case ir.Bernoulli():
                width = threshold(self.value(dist.probability, frame))
                return share(np.where(value, width, _RANGE - width))
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
            case ir.Binned():
                return self.density_of_bin(dist, frame, value)
            case ir.Widened():
                assert isinstance(dist.dist.type, Int)
                inside = (value >= dist.dist.type.low) & (value <= dist.dist.type.high)
                return np.where(inside, self.density(dist.dist, frame, value), 0.0)
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

    def _weights(self, dist: ir.Weighted, frame: Frame) -> list[tuple[Array, Array, Array]]:
        """Return, for each value of the binder, the value, where it can be drawn, and the sum up to it."""
        found = []
        total: Array = np.zeros(())
        for _, _, values in combinations(dist.binders):
            inner = frame.bind(values)
            weight = self.value(dist.weight, inner)
            match = self.holds(dist.condition, inner) & (weight > 0.0)
            total = np.where(match, total + weight.astype(np.float64), total)
            found.append((values[dist.binders[0].name], match, total))
        return found

    def _sample_weighted(self, dist: ir.Weighted, frame: Frame, word: Word) -> Array:
        found, draw = self._weights(dist, frame), word()
        total = found[-1][2]
        result = found[0][0]
        for value, match, _ in found:
            result = np.where(match, value, result)  # the last match, unless one before it is hit
        for value, match, until in reversed(found):
            result = np.where(match & (draw < words_of(until / total)), value, result)
        if dist.otherwise is not None:
            result = np.where(total > 0.0, result, self.sample(dist.otherwise, frame, word))
        return as_type(result, dist.type)

    def _density_of_weighted(self, dist: ir.Weighted, frame: Frame, value: Array) -> Array:
        found = self._weights(dist, frame)
        total = found[-1][2]
        words: Array = np.zeros((), dtype=np.uint64)
        before: Array = np.zeros(())
        later: Array = np.zeros((), dtype=np.bool_)
        for candidate, match, until in reversed(found):
            end = np.where(later, words_of(until / total), _RANGE)
            words = np.where(match & (candidate == value), end, words)
            later = later | match
        for candidate, match, until in found:
            words = np.where(match & (candidate == value), words - words_of(before / total), words)
            before = until
        if dist.otherwise is not None:
            empty = self.density(dist.otherwise, frame, value)
        else:
            empty = np.where(found[0][0] == value, 1.0, 0.0)
        return np.where(total > 0.0, share(words), empty)

    # Tables ----------------------------------------------------------------------------------

    def _sample_table(self, dist: ir.Table, frame: Frame, word: Word) -> Array:
        entries = [(self.value(v, frame), threshold(self.value(p, frame))) for v, p in dist.entries]
        draw = word()
        result = entries[-1][0] if dist.rest is None else self.value(dist.rest, frame)
        total: Any = np.uint64(0)
        taken: Any = np.zeros(draw.shape, dtype=np.bool_)
        for value, width in entries:
            total = total + width
            take = ~taken & (draw < total)
            result = np.where(take, value, result)
            taken = taken | take
        return as_type(result, dist.type)

    def _density_of_table(self, dist: ir.Table, frame: Frame, value: Array) -> Array:
        words: Array = np.zeros((), dtype=np.uint64)
        total: Array = np.zeros((), dtype=np.uint64)
        for entry, weight in dist.entries:
            end = np.minimum(total + threshold(self.value(weight, frame)), _RANGE)
            words = np.where(self.value(entry, frame) == value, words + (end - total), words)
            total = end
        rest = dist.entries[-1][0] if dist.rest is None else dist.rest
        return share(np.where(self.value(rest, frame) == value, words + (_RANGE - total), words))

    # Noisy values ----------------------------------------------------------------------------

    def _sample_noisy(self, dist: ir.Noisy, frame: Frame, word: Word) -> Array:
        exact = self.value(dist.value, frame)
        size = size_of(dist.type)
        if size == 1:
            return exact
        draw, width = word(), threshold(self.value(dist.probability, frame))
        room = np.where(width < _RANGE, _RANGE - width, np.uint64(1))
        beyond = np.where(draw < width, np.uint64(0), draw - width)
        other = (beyond * np.uint64(size - 1) // room).astype(np.int64)
        position = exact.astype(np.int64) - low_of(dist.type)
        other = other + (other >= position)
        return as_type(np.where(draw < width, exact, from_position(other, dist.type)), dist.type)

    def _density_of_noisy(self, dist: ir.Noisy, frame: Frame, value: Array) -> Array:
        exact = self.value(dist.value, frame)
        size = size_of(dist.type)
        if size == 1:
            return np.where(exact == value, 1.0, 0.0)
        width = threshold(self.value(dist.probability, frame))
        return np.where(exact == value, share(width), share(_RANGE - width) / (size - 1))
