# SPDX-License-Identifier: Apache-2.0
"""Beliefs about floats that a policy knows by mean and deviation, in each lane.

docs/internals/beliefs.md fixes every operation, so that generated code gives the same bits.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.moments import POINTS, Law, Mixture, Points, Shares, Update
from hypgen.dsl.interpret.evaluate.values import Array, Frame, State, combinations
from hypgen.dsl.interpret.posteriors import Posterior, Posteriors


class MomentBeliefs:
    """Computes mean and deviation of the floats of a model's factors: lanes, members, two numbers."""

    def __init__(self, model: ir.Model, evaluator: Evaluator, posteriors: Posteriors, lanes: int) -> None:
        self._model = model
        self._evaluator = evaluator
        self._posteriors = posteriors
        self._lanes = np.arange(lanes)

    def start(self, state: State, elements: Collection[str]) -> Posterior:
        """Return the beliefs before the first step; ``state`` has the visible variables."""
        return {f.element: self._start(f, state) for f in self._kept(elements)}

    def advance(
        self, state: State, action: Array, after: State, seen: Mapping[str, Array], now: Posterior
    ) -> Posterior:
        """Return the beliefs ``now`` after a step that was not terminal."""
        result: Posterior = {}
        code = np.broadcast_to(action, self._lanes.shape)
        for factor in self._kept(now):
            known = result[factor.element] = now[factor.element].copy()
            frame = Frame(self._lanes, dict(state), after=dict(after), action=code)
            for member in range(factor.members):
                moved = self._moved(factor, member, frame, known[:, member])
                known[:, member] = self._weighed(factor, factor.evidence, member, frame, seen, moved)
        return result

    def _kept(self, elements: Collection[str]) -> list[ir.Factor]:
        return [f for f in self._model.factors if f.moments is not None and f.element in elements]

    def _start(self, factor: ir.Factor, state: State) -> Array:
        result = np.zeros((len(self._lanes), factor.members, 2), dtype=np.float32)
        frame = Frame(self._lanes, dict(state))
        for member in range(factor.members):
            mixture = Mixture(len(self._lanes))
            self._add(factor, self._model.inits, member, frame, mixture)
            result[:, member] = self._weighed(factor, factor.first, member, frame, state, mixture.kept())
        return result

    def _moved(self, factor: ir.Factor, member: int, frame: Frame, now: Array) -> Array:
        """Return what the step makes of mean and deviation, before anything is seen."""
        assert factor.moments is not None
        if factor.moments.still:
            return now
        law = self._law(factor, member, frame, now)
        points, mixture = Points(law, law.mean, law.deviation), Mixture(len(self._lanes))
        for k in range(POINTS):
            x = points.at(k)
            trial = self._put(factor, member, x, frame)
            with np.errstate(all="ignore"):
                mixture.at(x, law.density(x))
            self._add(factor, self._model.updates, member, trial, mixture)
        return mixture.moved(now)

    def _weighed(
        self,
        factor: ir.Factor,
        pieces: tuple[ir.Evidence, ...],
        member: int,
        frame: Frame,
        seen: Mapping[str, Array],
        now: Array,
    ) -> Array:
        """Return mean and deviation given what was seen."""
        with np.errstate(all="ignore"):
            update = Update(self._law(factor, member, frame, now))
            while pieces and update.due():
                x = update.points()
                trial = self._put(factor, member, x.reshape(-1), _repeated(frame, POINTS))
                copies = {name: np.repeat(values, POINTS, axis=0) for name, values in seen.items()}
                likelihood = np.ones(x.size)
                for evidence in pieces:
                    for chance in self._posteriors.likelihood(evidence, member, trial, copies):
                        likelihood = likelihood * chance
                update.sweep(x, likelihood.reshape(x.shape))
            return update.kept()

    def _law(self, factor: ir.Factor, member: int, frame: Frame, known: Array) -> Law:
        """Return the law that a member's mean and deviation stand for."""
        return Law(known, self._evaluator.ends(factor, np.asarray(member), frame))

    def _put(self, factor: ir.Factor, member: int, x: Array, frame: Frame) -> Frame:
        """Return a frame in which the member's float is ``x``, before and after the step."""
        assert factor.moments is not None
        name = factor.moments.variable
        place = (slice(None), member) if factor.binder is not None else (slice(None),)
        state = {**frame.state, name: frame.state[name].copy()}
        state[name][place] = x
        after = None
        if frame.after is not None:
            after = {**frame.after, name: state[name]}
        return Frame(frame.lanes, state, after=after, action=frame.action)

    def _add(
        self,
        factor: ir.Factor,
        assigns: tuple[ir.Assign, ...],
        member: int,
        frame: Frame,
        mixture: Mixture,
    ) -> None:
        """Add the law that gives the member's float its value."""
        assert factor.moments is not None
        assign = next(a for a in assigns if a.variable == factor.moments.variable)
        for _, place, values in combinations(assign.binders):
            if place in ((), (member,)):
                with np.errstate(all="ignore"):
                    self._add_law(assign.dist, frame.bind(values), np.asarray(1.0), mixture)

    def _add_law(self, dist: ir.Dist, frame: Frame, share: Array, mixture: Mixture) -> None:
        """Add a law with a share of each lane, 0 where another law stands in its place."""
        value = self._evaluator.value
        match dist:
            case ir.Certain():
                mixture.certain(share, value(dist.value, frame))
            case ir.Normal():
                mixture.normal(share, value(dist.mean, frame), value(dist.deviation, frame))
            case ir.UniformFloat():
                mixture.uniform(share, value(dist.low, frame), value(dist.high, frame))
            case ir.Exponential():
                mixture.exponential(share, value(dist.mean, frame))
            case ir.Table():
                shares = Shares()
                masses = self._evaluator.masses(dist, frame)
                for (entry, _), mass in zip(dist.entries, masses, strict=False):
                    part = shares.take(mass)
                    mixture.certain(share * part, value(entry, frame))
                last = dist.entries[-1][0] if dist.rest is None else dist.rest
                mixture.certain(share * shares.rest(), value(last, frame))
            case ir.IfDist():
                holds = value(dist.condition, frame)
                self._add_law(dist.then, frame, np.where(holds, share, 0.0), mixture)
                self._add_law(dist.otherwise, frame, np.where(holds, 0.0, share), mixture)
            case ir.LetDist():
                inner = frame.bind({dist.name: value(dist.value, frame)})
                self._add_law(dist.body, inner, share, mixture)
            case _:
                raise TypeError(f"no mean of {type(dist).__name__}")


def _repeated(frame: Frame, copies: int) -> Frame:
    """Return the frame with each lane so many times."""
    state, after = (
        None if s is None else {n: np.repeat(v, copies, axis=0) for n, v in s.items()}
        for s in (frame.state, frame.after)
    )
    assert state is not None
    action = None if frame.action is None else np.repeat(frame.action, copies)
    return Frame(np.arange(len(frame.lanes) * copies), state, after=after, action=action)
