# SPDX-License-Identifier: Apache-2.0
"""An interpreter that adds to findings what goes wrong while it runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, Frame, History, State, combinations
from hypgen.dsl.interpret.floats.philox import DrawSource
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.sampling.findings import Findings, Place
from hypgen.dsl.interpret.sampling.watched_evaluation import Watch
from hypgen.dsl.messages import c_sampling
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Float

# Rewards are fixed-point numbers that saturate here.
_LARGEST_REWARD = 2.0**24


class WatchedInterpreter(Interpreter):
    """Runs a model; ``watch.active`` says which lanes count."""

    def __init__(self, model: ir.Model, findings: Findings, *, lanes: int) -> None:
        self.watch = Watch(model, {}, findings)
        super().__init__(model, lanes=lanes, evaluator=self.watch)
        self._rewards = {id(r.value): r for r in model.rewards}
        self.paid: set[str] = set()  # rewards that were not 0 in some lane that counts
        named = ("legal", "terminal", "success", "upper", "lower", "tail")
        self.places = {
            name: Place(model.spans.get(name), (getattr(model, name),))
            for name in named
            if getattr(model, name) is not None
        }
        self._names = {id(getattr(model, name)): name for name in self.places}
        if model.policy is not None:
            self.places["policy"] = Place(model.policy.dist.span, (model.policy.dist,), model.policy.binders)

    def legal_actions(self, state: State) -> Array:
        """Return, for each action and lane, whether the action is legal."""
        with self.watch.at(self.places["legal"]):
            return super().legal_actions(state)

    def policy_choice(
        self, policy: ir.Policy, state: State, draws: DrawSource, history: History | None = None
    ) -> Array:
        """Return the action that the policy declares, legal or not."""
        with self.watch.at(self.places["policy"]):
            return super().policy_choice(policy, state, draws, history)

    def note(
        self,
        part: str,
        finding: Callable[[int, Span | None], Diagnostic],
        bad: npt.NDArray[np.bool_] | np.bool_,
        state: State,
        history: History,
    ) -> None:
        """Add a finding about a part of the model if a lane that counts is bad."""
        with self.watch.at(self.places[part]):
            self.watch.note(finding, bad, self._frame(state, history=history))

    def check_invariants(self, state: State) -> None:
        """Add a finding for each invariant that does not hold in a state that counts."""
        for invariant in self.model.invariants:
            binders = () if invariant.binder is None else (invariant.binder,)
            with self.watch.at(Place(invariant.span, (invariant.condition,), binders)):
                for _, _, values in combinations(binders):
                    frame = self._frame(state).bind(values)
                    self.watch.note(
                        lambda _, span: c_sampling.broken_invariant(span),
                        ~self._spread(invariant.condition, frame),
                        frame,
                    )

    def advance_history(
        self, state: State, action: npt.ArrayLike, key: npt.ArrayLike, next_state: State, history: History
    ) -> History:
        """Return the histories after an action; its hypotheses need not be possible, so nothing counts."""
        with self.watch.only(np.asarray(np.False_)):
            return super().advance_history(state, action, key, next_state, history)

    def _assign(self, assign: ir.Assign, frame: Frame, target: State, member: int | None = None) -> None:
        place = Place(assign.span, (assign.dist,), assign.binders)
        with self.watch.at(place):
            super()._assign(assign, frame, target, member)
            if isinstance(self._evaluator.variables[assign.variable].type, Float):
                values = target[assign.variable].reshape(self.lanes, -1)
                self.watch.note(
                    lambda lane, span: c_sampling.infinite_variable(
                        assign.variable, _odd(values[lane]), span
                    ),
                    ~np.isfinite(values).all(axis=1),
                    frame,
                )

    def _observe(self, observation: ir.Observation, frame: Frame) -> Array:
        with self.watch.at(Place(observation.span, (observation.dist,), observation.binders)):
            return super()._observe(observation, frame)

    def _spread(self, e: ir.Expr, frame: Frame) -> Array:
        reward = self._rewards.get(id(e))
        if reward is None:
            name = self._names.get(id(e))
            if name is None:
                return super()._spread(e, frame)
            with self.watch.at(self.places[name]):
                value = super()._spread(e, frame)
                if name in ("upper", "lower", "tail"):
                    self._check_bound(name, value, frame)
                return value
        with self.watch.at(Place(reward.span, (e,), () if reward.binder is None else (reward.binder,))):
            value = super()._spread(e, frame)
            self.watch.note(
                lambda lane, span: c_sampling.infinite_reward(reward.name, value[lane], span),
                ~(np.abs(value.astype(np.float64)) <= _LARGEST_REWARD),
                frame,
            )
        if reward.name not in self.paid and np.any((value != 0) & self.watch.active):
            self.paid.add(reward.name)
        return value

    def _check_bound(self, name: str, value: Array, frame: Frame) -> None:
        self.watch.note(
            lambda lane, span: c_sampling.infinite_bound(name, value[lane], span),
            ~np.isfinite(value.astype(np.float64)),
            frame,
        )


def _odd(values: Array) -> str:
    return f"{values[~np.isfinite(values)][0]}"
