# SPDX-License-Identifier: Apache-2.0
"""The exact posterior of each factor, in each lane: what the agent knows of hidden state.

docs/internals/beliefs.md fixes every operation, so that generated code gives the same bits.
Numbers are float64 in the agent's belief and float32 in the history of policies.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame, State, combinations, from_position, to_position
from hypgen.dsl.types import size_of

Posterior = dict[str, Array]  # of each exact factor's element: lanes, members, joint values


@dataclass(frozen=True)
class _Entry:
    """A scalar among a member's hidden variables: its array, its place there, the binders' values."""

    assign: ir.Assign
    variable: ir.Variable
    place: tuple[int, ...]
    values: dict[str, Array]


class Posteriors:
    """Computes the posteriors of a model's exact factors."""

    def __init__(self, model: ir.Model, evaluator: Evaluator, lanes: int) -> None:
        self.model = model
        self._evaluator = evaluator
        self._lanes = np.arange(lanes)
        self.factors = [f for f in model.factors if f.exact]

    def start(self, state: State, elements: Collection[str], kind: type[np.floating[Any]]) -> Posterior:
        """Return posteriors of a kind before the first step; ``state`` has the visible variables.

        A posterior under which what is seen at the start has probability 0 is what the inits alone say.
        """
        return {f.element: self._start(f, state, kind) for f in self.factors if f.element in elements}

    def advance(
        self, state: State, action: Array, after: State, seen: Mapping[str, Array], now: Posterior
    ) -> tuple[Posterior, Array]:
        """Return the posteriors ``now`` after a step that was not terminal, and where all are possible.

        ``state`` and ``after`` have the visible variables, ``seen`` has the observations: lanes by entries. A
        posterior under which what was seen has probability 0 stays as it was.
        """
        possible = np.ones(len(self._lanes), dtype=np.bool_)
        result: Posterior = {}
        for factor in self.factors:
            if factor.element not in now:
                continue
            result[factor.element] = now[factor.element].copy()
            for member in range(factor.members):
                frame = Frame(self._lanes, dict(state), after=dict(after), action=action)
                step = _Step(self, factor, member, frame, seen)
                after_member, fine = step.advance(now[factor.element][:, member])
                result[factor.element][:, member] = after_member
                possible &= fine
        return result, possible

    def _start(self, factor: ir.Factor, state: State, kind: type[np.floating[Any]]) -> Array:
        sums_of = np.float64 if self.model.weighs_floats(factor.first) else kind
        result = np.zeros((len(self._lanes), factor.members, factor.size), dtype=sums_of)
        unseen = np.zeros_like(result)
        for member, h in itertools.product(range(factor.members), range(factor.size)):
            trial = self.copied(factor, state)
            entries = list(self.entries(factor, member, self.model.inits))
            self.put(factor, member, h, trial)
            weight = np.ones(len(self._lanes), dtype=np.float64)
            frame = Frame(self._lanes, trial)
            for entry in entries:
                weight = weight * self.density(entry, frame, trial)
            unseen[:, member, h] = weight
            for evidence in factor.first:
                for chance in self.likelihood(evidence, member, frame, trial):
                    weight = weight * chance
            result[:, member, h] = weight
        explained = (total(result) > 0)[..., np.newaxis]
        sums = np.where(explained, result, unseen)
        return stored((sums / total(sums)[..., np.newaxis]).astype(kind))

    # Hypotheses ------------------------------------------------------------------------------

    def entries(self, factor: ir.Factor, member: int, assigns: tuple[ir.Assign, ...]) -> Iterator[_Entry]:
        """Yield the member's hidden scalars in the order of ``assigns``, entries row-major."""
        for assign in assigns:
            if assign.variable not in factor.variables:
                continue
            variable = self.model.variable(assign.variable)
            for _, place, values in combinations(assign.binders):
                if factor.binder is None or place[0] == member:
                    yield _Entry(assign, variable, place, values)

    def copied(self, factor: ir.Factor, state: State) -> State:
        """Return a state whose hidden variables of the factor may be written."""
        return {n: v.copy() if n in factor.variables else v for n, v in state.items()}

    def places(self, factor: ir.Factor, member: int) -> Iterator[tuple[ir.Variable, tuple[int, ...]]]:
        """Yield the member's hidden scalars in the order in which their joint values are coded."""
        for name in factor.variables:
            variable = self.model.variable(name)
            for place in np.ndindex(*(size_of(t) for t in variable.indices)):
                if factor.binder is None or place[0] == member:
                    yield variable, place

    def put(self, factor: ir.Factor, member: int, value: int, *states: State) -> None:
        """Write a joint value into states."""
        for variable, place in reversed(list(self.places(factor, member))):
            value, digit = divmod(value, size_of(variable.type))
            for state in states:
                state[variable.name][_lanes_of(place)] = from_position(np.asarray(digit), variable.type)

    def fixed_part(self, factor: ir.Factor, value: int) -> list[int]:
        """Return the digits of a joint value that never change."""
        digits = []
        for variable, _ in reversed(list(self.places(factor, 0))):
            value, digit = divmod(value, size_of(variable.type))
            digits += [digit] if variable.fixed else []
        return digits

    def code(self, factor: ir.Factor, member: int, state: State) -> Array:
        """Return the joint value in each lane."""
        code = np.zeros((), dtype=np.int64)
        for variable, place in self.places(factor, member):
            digit = to_position(state[variable.name][_lanes_of(place)], variable.type)
            code = code * size_of(variable.type) + digit
        return code

    def density(self, entry: _Entry, frame: Frame, state: State) -> Array:
        """Return the density of the value that ``state`` holds."""
        value = state[entry.variable.name][_lanes_of(entry.place)]
        with np.errstate(all="ignore"):
            return self._evaluator.density(entry.assign.dist, frame.bind(entry.values), value)

    def draw(self, entry: _Entry, frame: Frame, state: State) -> None:
        """Write the value of an update that draws nothing."""
        assert isinstance(entry.assign.dist, ir.Certain)
        with np.errstate(all="ignore"):
            value = self._evaluator.value(entry.assign.dist.value, frame.bind(entry.values))
        state[entry.variable.name][_lanes_of(entry.place)] = value

    @property
    def updates(self) -> tuple[ir.Assign, ...]:
        """Return the updates stage by stage."""
        return tuple(update for stage in self.model.stages() for update in stage)

    def likelihood(
        self, evidence: ir.Evidence, member: int, frame: Frame, seen: Mapping[str, Array]
    ) -> Iterator[Array]:
        """Yield how likely each entry of what was seen is, 1 where it does not touch the member."""
        assigns = self.model.inits if evidence.kind == "first" else self.model.updates
        laws = {o.name: o.dist for o in self.model.observations} | {a.variable: a.dist for a in assigns}
        for number, _, values in combinations(evidence.binders):
            inner = frame.bind(values)
            with np.errstate(all="ignore"):
                touched = self._evaluator.value(evidence.touch, inner) == member
                if not np.any(touched):
                    continue
                if evidence.condition is not None:
                    chance = np.where(self._evaluator.value(evidence.condition, inner), 0.0, 1.0)
                else:
                    found = frame.after if evidence.kind == "visible" else seen
                    assert found is not None
                    value = found[evidence.name].reshape(len(frame.lanes), -1)[:, number]
                    chance = self._evaluator.density(laws[evidence.name], inner, value)
            yield np.where(touched, chance, 1.0)


@dataclass(frozen=True)
class _Step:
    """One member's posterior over one step."""

    of: Posteriors
    factor: ir.Factor
    member: int
    frame: Frame
    seen: Mapping[str, Array]

    def advance(self, now: Array) -> tuple[Array, Array]:
        """Return the posterior after the step, and where it is possible: lanes by joint values."""
        kind = np.float64 if self.of.model.weighs_floats(self.factor.evidence) else now.dtype.type
        sums = np.zeros(now.shape, dtype=kind)
        same = np.ones(len(now), dtype=np.bool_)
        for h in range(self.factor.size):
            held = now[:, h] > 0
            if not held.any():
                continue
            weights = self._weights(h)
            same &= ~held | (weights == (np.arange(self.factor.size) == h)).all(axis=1)
            shares = now[:, h, np.newaxis].astype(kind) * weights.astype(kind)
            sums += np.where(held[:, np.newaxis], shares, kind(0))
        whole = total(sums)
        possible = same | (whole > 0)
        divisor = np.where(whole > 0, whole, kind(1))[:, np.newaxis]
        after = np.where((same | ~possible)[:, np.newaxis], now, stored((sums / divisor).astype(now.dtype)))
        return after, possible

    def _weights(self, h: int) -> Array:
        """Return how likely each joint value after the step is, with what was seen, given ``h`` before."""
        of, factor, lanes = self.of, self.factor, len(self.frame.lanes)
        entries = list(of.entries(factor, self.member, of.updates))
        if all(isinstance(e.assign.dist, ir.Certain) for e in entries):
            frame, seen = self._hypothesis(h, 1)
            assert frame.after is not None
            for entry in entries:
                of.draw(entry, frame, frame.after)
            result = np.zeros((lanes, factor.size))
            code = of.code(factor, self.member, frame.after)
            result[np.arange(lanes), code] = self._weigh(np.ones(lanes), frame, seen)
            return result
        frame, seen = self._hypothesis(h, factor.size)
        assert frame.after is not None
        fixed = np.array([of.fixed_part(factor, g) == of.fixed_part(factor, h) for g in range(factor.size)])
        weight = np.tile(fixed.astype(np.float64), lanes)
        for g in range(factor.size):
            of.put(factor, self.member, g, {n: v[g :: factor.size] for n, v in frame.after.items()})
        for entry in entries:
            weight = weight * of.density(entry, frame, frame.after)
        return self._weigh(weight, frame, seen).reshape(lanes, factor.size)

    def _hypothesis(self, h: int, copies: int) -> tuple[Frame, dict[str, Array]]:
        """Return what the step is evaluated in if the joint value was ``h``, each lane so many times."""
        frame = self.frame
        assert frame.after is not None and frame.action is not None
        action = np.broadcast_to(frame.action, frame.lanes.shape)
        state, after = (
            {n: np.repeat(v, copies, axis=0) for n, v in s.items()} for s in (frame.state, frame.after)
        )
        seen = {n: np.repeat(v, copies, axis=0) for n, v in self.seen.items()}
        self.of.put(self.factor, self.member, h, state, after)  # after too: for variables that never change
        lanes = np.arange(len(frame.lanes) * copies)
        return Frame(lanes, state, after=after, action=np.repeat(action, copies)), seen

    def _weigh(self, weight: Array, frame: Frame, seen: Mapping[str, Array]) -> Array:
        for evidence in self.factor.evidence:
            for chance in self.of.likelihood(evidence, self.member, frame, seen):
                weight = weight * chance
        return weight


def _lanes_of(place: tuple[int, ...]) -> tuple[slice | int, ...]:
    """Return the index of one entry in all lanes."""
    return (slice(None), *place)


def total(values: Array) -> Array:
    """Return the sum over the last axis, in order."""
    result = np.zeros(values.shape[:-1], dtype=values.dtype)
    for column in range(values.shape[-1]):
        result = result + values[..., column]
    return result


def stored(posterior: Array) -> Array:
    """Return the posterior as it is kept: of two values, only the second's probability is."""
    if posterior.shape[-1] == 2:
        posterior = posterior.copy()
        posterior[..., 0] = posterior.dtype.type(1) - posterior[..., 1]
    return posterior
