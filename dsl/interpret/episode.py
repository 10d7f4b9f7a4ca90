# SPDX-License-Identifier: Apache-2.0
"""One episode, step by step, in the world in which a solver with the same seed plays it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, History, State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive, philox
from hypgen.dsl.interpret.interpreter import Interpreter, pick_legal
from hypgen.dsl.interpret.posteriors import Posteriors

_RANDOM_SITE = 0xAC7

Values = dict[str, list[Any]]


@dataclass(frozen=True)
class Moment:
    """Where an episode stands before step ``time``: all that the next step depends on.

    ``action`` and ``key`` are what was done and seen in the step before, if it was not the last one.
    """

    time: int
    state: State
    history: History
    earned: float
    discounted: float
    terminal: bool
    success: bool
    action: int = -1
    key: Array | None = None


@dataclass(frozen=True)
class Outcome:
    """What a step gave: the reward in all and by term, and what was observed (nothing in a last step).

    ``observation`` has the entries of each observation, row-major.
    """

    action: int
    reward: float
    terms: dict[str, float]
    observation: Values
    error: bool


class Episode:
    """An episode of a model; ``number`` is the run of the solver that plays in the same world."""

    def __init__(self, model: ir.Model, seed: int = 0, number: int = 0) -> None:
        self.model = model
        self._interpreter = Interpreter(model)
        self._world = derive(seed, Stream.WORLD, 0)
        self._seed, self._number = seed, number
        draws = PhiloxDraws(self._world, number, 0)
        state = self._interpreter.init_hidden(self._interpreter.init_visible(draws), draws)
        history = self._interpreter.init_history(state)
        self._moments = [Moment(0, state, history, 0.0, 0.0, False, False)]

    @property
    def now(self) -> Moment:
        """Return where the episode stands."""
        return self._moments[-1]

    def values(self) -> Values:
        """Return the entries of every variable, row-major."""
        return {name: array[0].reshape(-1).tolist() for name, array in self.now.state.items()}

    def legal(self) -> list[int]:
        """Return the codes of the actions that are legal now; none once the episode has ended."""
        if self.now.terminal:
            return []
        return np.flatnonzero(self._interpreter.legal_actions(self.now.state)[:, 0]).tolist()

    def policy_action(self) -> int:
        """Return what the default policy does here in a solver's episode, -1 if nothing is legal."""
        plan = derive(self._seed, Stream.PLAN, (self._number << 20) + self.now.time)
        draws = PhiloxDraws(plan, 0, 0)
        return int(self._interpreter.default_policy(self.now.state, draws, self.now.history)[0])

    def random_action(self) -> int:
        """Return a legal action, each as likely as the others, -1 if nothing is legal."""
        key = derive(self._seed, Stream.TEST, self._number)
        word = philox(key, (0, self.now.time, _RANDOM_SITE, 0))[0]
        return int(pick_legal(self._interpreter.legal_actions(self.now.state), word)[0])

    def memory(self) -> Values:
        """Return the entries of each of the policy's registers, row-major."""
        history = self.now.history
        return {
            r.name: history[f"memory {r.name}"][0].reshape(-1).tolist() for r in self.model.history.registers
        }

    def belief(self) -> dict[str, list[list[float]]]:
        """Return what the agent believes, for each member of each exact factor: its values' probabilities."""
        posteriors = Posteriors(self.model, Evaluator(self.model, {}), 1)
        first, *later = self._moments
        now = posteriors.start(first.state, {f.element for f in posteriors.factors}, np.float64)
        before = first
        for moment in later:
            if moment.key is not None:
                action, seen = np.asarray(moment.action), self._interpreter.decode(moment.key)
                now, _ = posteriors.advance(before.state, action, moment.state, seen, now)
            before = moment
        return {element: values[0].tolist() for element, values in now.items()}

    def moments(self) -> dict[str, list[list[float]]]:
        """Return mean and deviation of the floats that the policy knows, for each member of a factor."""
        history = self.now.history
        matched = [f.element for f in self.model.factors if f.moments is not None]
        kept = [element for element in matched if element in self.model.history.beliefs]
        return {element: history[f"belief {element}"][0].tolist() for element in kept}

    def step(self, action: int) -> Outcome:
        """Take a legal action."""
        now, run = self.now, self._interpreter
        draws = PhiloxDraws(self._world, self._number, now.time)
        done = run.step(now.state, action, draws)
        terms = run.reward_terms(now.state, action, draws, done.after)
        terminal = bool(done.terminal[0])
        seen: Values = {}
        history, key = now.history, None
        if not terminal:
            key = run.observe(now.state, action, draws, done.after)
            decoded = run.decode(key)
            seen = {o.name: decoded[o.name][0].tolist() for o in self.model.observations}
            history = run.advance_history(now.state, action, key, done.after, history)
        reward = self._units(done.reward)
        self._moments.append(
            Moment(
                now.time + 1,
                done.after,
                history,
                now.earned + reward,
                now.discounted + self.model.discount**now.time * reward,
                terminal,
                now.success or bool(done.success[0]),
                action,
                key,
            )
        )
        shown = {name: self._units(term) for name, term in terms.items()}
        return Outcome(action, reward, shown, seen, bool(done.error[0]))

    def undo(self) -> bool:
        """Take the last step back; return False at the start. Taken again, it draws the same."""
        if len(self._moments) == 1:
            return False
        self._moments.pop()
        return True

    def _units(self, fixed: Any) -> float:
        """Return one lane's fixed-point sum as a number."""
        return float(fixed[0]) * 2.0**-self.model.reward_bits
