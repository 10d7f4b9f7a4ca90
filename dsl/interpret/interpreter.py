# SPDX-License-Identifier: Apache-2.0
"""The reference semantics of a model, in numpy, for many lanes at once.

Slow beside generated code and written independently of it, so that the two check each other bit for bit.
Each method is the function of the same name that a generated model has (the contract in
``runtime/include/hypgen/model/model.hpp``), for ``lanes`` scenarios instead of one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import (
    Array,
    Frame,
    History,
    State,
    combinations,
    dtype_of,
    from_digit,
    to_digit,
    to_position,
)
from hypgen.dsl.interpret.floats.philox import DrawSource
from hypgen.dsl.interpret.floats.scalar_functions import saturate_fixed, to_fixed
from hypgen.dsl.interpret.moment_beliefs import MomentBeliefs
from hypgen.dsl.interpret.posteriors import Posterior, Posteriors
from hypgen.dsl.ir import Binder, key_digits
from hypgen.dsl.types import Type, length_of, size_of

_DEFAULT_POLICY_SITE = ir.Site("policy:default")


class Step(NamedTuple):
    """What a step gives in each lane; the reward in fixed point, ``error`` where a term of it was NaN."""

    after: State
    reward: Array
    terminal: Array
    success: Array
    error: Array


class Interpreter:
    """Runs a model. ``params`` overrides defaults, entries row-major or nested, enums as codes.

    A state maps each variable to an array with the lanes first; actions are arrays of codes. A history has
    ``memory NAME`` for each register, ``last NAME`` for each kept observation, ``action`` (a code) and
    ``started``: whether there was a step before; a model that keeps nothing needs none.
    """

    def __init__(
        self,
        model: ir.Model,
        params: Mapping[str, Sequence[Any] | Any] | None = None,
        *,
        lanes: int = 1,
        evaluator: Evaluator | None = None,
    ) -> None:
        self.model = model
        self.lanes = lanes
        self._lanes = np.arange(lanes)
        self._evaluator = evaluator or Evaluator(model, params or {})
        self._posteriors = Posteriors(model, self._evaluator, lanes)
        self._moments = MomentBeliefs(model, self._evaluator, self._posteriors, lanes)
        self._digits = key_digits.digits(model.key)
        self._key_words = key_digits.word_count(model.key)

    # Episode start ---------------------------------------------------------------------------

    def init_visible(self, draws: DrawSource) -> State:
        """Return states in which the visible variables are drawn, and what these read.

        Hidden variables are 0 where no visible one reads any; ``init_hidden`` draws them again.
        """
        state = {v.name: self._zeros(v) for v in self.model.variables}
        self._initialise(state, draws, visible=True)
        return state

    def init_hidden(self, state: State, draws: DrawSource) -> State:
        """Return the states with their hidden variables drawn, given the visible ones."""
        result = {name: values.copy() for name, values in state.items()}
        self._initialise(result, draws, visible=False)
        return result

    def init_likelihood(self, state: State) -> Array:
        """Return how likely the informative variables' values are at the start, given all others: float64."""
        weight, frame = np.ones(self.lanes, dtype=np.float64), self._frame(state)
        for init in self.model.first_seen:
            seen = state[init.variable].reshape(self.lanes, -1)
            weight = self._weigh(weight, init.binders, init.dist, frame, seen)
        return weight

    def _zeros(self, variable: ir.Variable) -> Array:
        return self._array(variable.type, variable.indices)

    def _array(self, t: Type, indices: tuple[Type, ...]) -> Array:
        return np.zeros((self.lanes, *(size_of(i) for i in indices)), dtype=dtype_of(t))

    def _initialise(self, state: State, draws: DrawSource, *, visible: bool) -> None:
        frame = self._frame(state, draws=draws)
        for group in self.model.init_groups(visible):
            if len(group) == 1:
                self._assign(group[0], frame, state)
                continue
            for member in range(size_of(group[0].binders[0].type)):
                for init in group:
                    self._assign(init, frame, state, member)

    # A step ----------------------------------------------------------------------------------

    def is_legal(self, state: State, action: npt.ArrayLike) -> Array:
        """Return where the action may be taken."""
        return self._spread(self.model.legal, self._frame(state, action=np.asarray(action)))

    def legal_actions(self, state: State) -> Array:
        """Return, for each action and lane, whether the action is legal."""
        codes = np.arange(self.model.action.count)[:, np.newaxis]
        with np.errstate(all="ignore"):
            legal = self._evaluator.value(self.model.legal, self._frame(state, action=codes))
        return np.broadcast_to(legal, (len(codes), self.lanes))

    def step(self, state: State, action: npt.ArrayLike, draws: DrawSource) -> Step:
        """Return what taking the action leads to."""
        frame = self._next_frame(state, np.asarray(action), draws)
        for update in self._updates():
            self._assign(update, frame, self._after(frame))
        reward = np.zeros(self.lanes, dtype=np.int64)
        error = np.zeros(self.lanes, dtype=np.bool_)
        for term in self.model.rewards:
            for earned in self._earned(term, frame):
                reward += to_fixed(earned, self.model.reward_bits)
                error |= np.isnan(earned)
        terminal = self._spread(self.model.terminal, frame)
        success = np.zeros_like(terminal)
        if self.model.success is not None:
            success = self._spread(self.model.success, frame)
        return Step(self._after(frame), saturate_fixed(reward), terminal, success, error)

    def reward_terms(
        self, state: State, action: npt.ArrayLike, draws: DrawSource, after: State
    ) -> dict[str, Array]:
        """Return what each reward term earns in a step, in fixed point, the members of a family summed."""
        frame = self._frame(state, after=after, action=np.asarray(action), draws=draws)
        return {
            term.name: sum(
                (to_fixed(earned, self.model.reward_bits) for earned in self._earned(term, frame)),
                np.zeros(self.lanes, np.int64),
            )
            for term in self.model.rewards
        }

    def _earned(self, term: ir.Reward, frame: Frame) -> Iterator[Array]:
        for _, _, values in combinations(() if term.binder is None else (term.binder,)):
            yield self._spread(term.value, frame.bind(values))

    def observe(self, state: State, action: npt.ArrayLike, draws: DrawSource, after: State) -> Array:
        """Return the observation keys of steps that were not terminal: lanes by words, uint64."""
        frame = self._frame(state, after=after, action=np.asarray(action), draws=draws)
        seen = {o.name: self._observe(o, frame) for o in self.model.observations}
        key = np.zeros((self.lanes, self._key_words), dtype=np.uint64)
        columns: dict[str, Array] = {}
        for field in self.model.key:
            values = (seen if field.observed else after)[field.name].reshape(self.lanes, -1)
            columns[field.name] = to_digit(values, field.type).astype(np.uint64)
        for digit in self._digits:
            key[:, digit.word] += columns[digit.field.name][:, digit.entry] * np.uint64(digit.place)
        return key

    def _observe(self, observation: ir.Observation, frame: Frame) -> Array:
        count = length_of(tuple(b.type for b in observation.binders))
        result = np.zeros((self.lanes, count), dtype=dtype_of(observation.type))
        with np.errstate(all="ignore"):
            for number, _, values in combinations(observation.binders):
                word = frame.word(observation.site.id, number)
                result[:, number] = self._evaluator.sample(observation.dist, frame.bind(values), word)
        return result

    def filter(
        self, state: State, action: npt.ArrayLike, key: npt.ArrayLike, draws: DrawSource
    ) -> tuple[Array, State]:
        """Return the weights (float64) of the states given what was seen, and their next states.

        Variables are treated stage by stage in the order of ``updates``, entries row-major. One that the key
        holds takes its value from there and multiplies the weight by that value's density unless it is
        ``copied``; the others are drawn. Then the weight is multiplied by the density of each observation
        digit, in the key's order. ``key`` is lanes by words, or one for all lanes.
        """
        seen = self.decode(np.asarray(key))
        frame = self._next_frame(state, np.asarray(action), draws)
        after = self._after(frame)
        weight = np.ones(self.lanes, dtype=np.float64)
        for update in self._updates():
            variable = self._evaluator.variables[update.variable]
            if update.variable not in seen:
                self._assign(update, frame, after)
                continue
            after[update.variable][...] = seen[update.variable].reshape(after[update.variable].shape)
            if not variable.copied:
                weight = self._weigh(weight, update.binders, update.dist, frame, seen[update.variable])
        weight = self._weigh_observations(weight, frame, seen)
        return np.where(self._spread(self.model.terminal, frame), 0.0, weight), after

    def observation_density(
        self, state: State, action: npt.ArrayLike, key: npt.ArrayLike, draws: DrawSource, after: State
    ) -> Array:
        """Return the density (float64) of the keys, given the states after steps that were not terminal.

        ``draws`` are those that made ``after``. 0 where a visible variable of the key is not that of
        ``after``, otherwise the product of the densities of the observations' digits, in the key's order.
        """
        seen = self.decode(np.asarray(key))
        frame = self._frame(state, after=after, action=np.asarray(action), draws=draws)
        agrees = np.ones(self.lanes, dtype=np.bool_)
        for field in self.model.key:
            if not field.observed:
                agrees &= (after[field.name].reshape(self.lanes, -1) == seen[field.name]).all(axis=1)
        return np.where(agrees, self._weigh_observations(np.ones(self.lanes), frame, seen), 0.0)

    def _weigh_observations(self, weight: Array, frame: Frame, seen: dict[str, Array]) -> Array:
        observations = {o.name: o for o in self.model.observations}
        for field in self.model.key:
            if field.observed:
                observation = observations[field.name]
                weight = self._weigh(weight, observation.binders, observation.dist, frame, seen[field.name])
        return weight

    def decode(self, key: Array) -> dict[str, Array]:
        """Return the values that the key holds: lanes by entries for each field."""
        words = np.broadcast_to(key, (self.lanes, self._key_words)).astype(np.uint64)
        columns: dict[str, list[Array]] = {f.name: [] for f in self.model.key}
        for digit in self._digits:
            value = words[:, digit.word] // np.uint64(max(digit.place, 1)) % np.uint64(digit.size)
            columns[digit.field.name].append(from_digit(value.astype(np.int64), digit.field.type))
        return {name: np.stack(values, axis=1) for name, values in columns.items()}

    def _weigh(
        self, weight: Array, binders: tuple[Binder, ...], dist: ir.Dist, frame: Frame, seen: Array
    ) -> Array:
        with np.errstate(all="ignore"):
            for number, _, values in combinations(binders):
                density = self._evaluator.density(dist, frame.bind(values), seen[:, number])
                weight = weight * density
        return weight

    # What the agent knows --------------------------------------------------------------------

    def init_posterior(self, state: State) -> Posterior:
        """Return the posterior of each exact factor at the start, given the visible variables."""
        return self._posteriors.start(state, [f.element for f in self._posteriors.factors], np.float64)

    def advance_posterior(
        self, state: State, action: npt.ArrayLike, key: npt.ArrayLike, after: State, now: Posterior
    ) -> tuple[Posterior, Array]:
        """Return the posteriors after a step that was not terminal, and where none became impossible.

        Of ``state`` and ``after`` only the visible variables are read.
        """
        seen = self.decode(np.asarray(key))
        return self._posteriors.advance(state, np.asarray(action), after, seen, now)

    # Policy and bounds -----------------------------------------------------------------------

    def init_history(self, state: State) -> History:
        """Return the histories at the start of episodes with these visible variables."""
        kept = self.model.history
        frame = self._frame(state)
        history = {
            "started": np.zeros(self.lanes, dtype=np.bool_),
            "action": np.zeros(self.lanes, dtype=np.int64),
        }
        for o in self.model.observations:
            if o.name in kept.observations:
                history[f"last {o.name}"] = self._array(o.type, tuple(b.type for b in o.binders))
        for r in kept.registers:
            history[f"memory {r.name}"] = self._fill(r, r.first, frame)
        posterior = self._posteriors.start(state, kept.beliefs, np.float32)
        posterior |= self._moments.start(state, kept.beliefs)
        return history | {f"belief {name}": values for name, values in posterior.items()}

    def advance_history(
        self, state: State, action: npt.ArrayLike, key: npt.ArrayLike, next_state: State, history: History
    ) -> History:
        """Return the histories after an action in the states, and what was seen then."""
        after = {"started": np.ones_like(history["started"])}
        after["action"] = np.broadcast_to(np.asarray(action, dtype=np.int64), (self.lanes,)).copy()
        seen = self.decode(np.asarray(key))
        for name in self.model.history.observations:
            after[f"last {name}"] = seen[name].reshape(history[f"last {name}"].shape)
        frame = self._frame(state, history=history)
        for r in self.model.history.registers:
            after[f"memory {r.name}"] = self._fill(r, r.update, frame)
        beliefs = {name: history[f"belief {name}"] for name in self.model.history.beliefs}
        posterior, _ = self._posteriors.advance(state, np.asarray(action), next_state, seen, beliefs)
        posterior |= self._moments.advance(state, np.asarray(action), next_state, seen, beliefs)
        return after | {f"belief {name}": values for name, values in posterior.items()}

    def _fill(self, register: ir.Register, entries: ir.Entries, frame: Frame) -> Array:
        result = self._array(register.type, register.indices)
        with np.errstate(all="ignore"):
            for _, place, values in combinations(entries.binders):
                lanes: tuple[slice | int, ...] = (slice(None), *place)
                result[lanes] = self._evaluator.value(entries.value, frame.bind(values))
        return result

    def default_policy(self, state: State, draws: DrawSource, history: History | None = None) -> Array:
        """Return the default policy's action; the lowest legal one if that is illegal, -1 without any."""
        policy = self.model.policy
        if policy is None:
            word = draws.word(_DEFAULT_POLICY_SITE.id, 0)
            return pick_legal(self.legal_actions(state), word)
        action = self.policy_choice(policy, state, draws, history)
        legal = self.is_legal(state, action)
        if legal.all():
            return action
        return np.where(legal, action, pick_legal(self.legal_actions(state), np.zeros(self.lanes, np.uint64)))

    def policy_choice(
        self, policy: ir.Policy, state: State, draws: DrawSource, history: History | None = None
    ) -> Array:
        """Return the action that the policy declares, legal or not."""
        frame = self._frame(state, history=history, draws=draws)
        action = np.zeros(self.lanes, dtype=np.int64)
        with np.errstate(all="ignore"):
            for number, _, values in combinations(policy.binders):
                word_of = frame.word(policy.site.id, number)
                choice = self._evaluator.sample(policy.dist, frame.bind(values), word_of)
                action = action * size_of(self.model.action.type) + to_position(
                    choice, self.model.action.type
                )
        return action

    def upper(self, state: State) -> Array:
        """Return the declared or derived upper bound."""
        return self._bound(self.model.upper, state)

    def tail(self, state: State) -> Array:
        """Return the value after the depth cut-off."""
        return self._bound(self.model.tail, state)

    def lower(self, state: State, history: History | None = None) -> Array:
        """Return the declared lower bound; 0 where there is none."""
        if self.model.lower is None:
            return np.zeros(self.lanes, dtype=np.float32)
        return self._bound(self.model.lower, state, history)

    def _bound(self, e: ir.Expr, state: State, history: History | None = None) -> Array:
        return self._spread(e, self._frame(state, history=history)).astype(np.float32)

    # Evaluation ------------------------------------------------------------------------------

    def _frame(
        self,
        state: State,
        *,
        after: State | None = None,
        action: Array | None = None,
        draws: DrawSource | None = None,
        history: History | None = None,
    ) -> Frame:
        return Frame(self._lanes, state, after=after, action=action, draws=draws, history=history)

    def _next_frame(self, state: State, action: Array, draws: DrawSource) -> Frame:
        after = {v.name: state[v.name] if v.fixed else self._zeros(v) for v in self.model.variables}
        return self._frame(state, after=after, action=action, draws=draws)

    def _updates(self) -> list[ir.Assign]:
        return [update for stage in self.model.stages() for update in stage]

    def _after(self, frame: Frame) -> State:
        assert frame.after is not None
        return frame.after

    def _assign(self, assign: ir.Assign, frame: Frame, target: State, member: int | None = None) -> None:
        """Assign all entries, or those of a family's member alone."""
        with np.errstate(all="ignore"):
            for number, place, values in combinations(assign.binders):
                if member is not None and place[0] != member:
                    continue
                word = frame.word(assign.site.id, number)
                value = self._evaluator.sample(assign.dist, frame.bind(values), word)
                lanes: tuple[slice | int, ...] = (slice(None), *place)
                target[assign.variable][lanes] = value

    def _spread(self, e: ir.Expr, frame: Frame) -> Array:
        """Return the expression's value with one entry for each lane."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(self._evaluator.value(e, frame), (self.lanes,))


def pick_legal(legal: Array, word: Array) -> Array:
    """Return the legal action numbered (word * count) >> 32 in each lane, -1 where none is legal."""
    count = legal.sum(axis=0)
    number = (word * count.astype(np.uint64) >> np.uint64(32)).astype(np.int64)
    rank = legal.cumsum(axis=0, dtype=np.int32) - 1
    action = np.argmax(legal & (rank == number), axis=0)
    return np.where(count > 0, action, -1)
