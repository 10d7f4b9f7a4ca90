# SPDX-License-Identifier: Apache-2.0
"""The belief about one hidden float on a fine grid: the reference of mean and deviation."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Frame, State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.posteriors import Posteriors

Array = npt.NDArray[Any]


class GridFilter:
    """Bayes' rule for the one float of the factor ``element``, no family, in cells of low .. high."""

    def __init__(self, model: ir.Model, element: str, low: float, high: float, cells: int) -> None:
        self.factor = next(f for f in model.factors if f.element == element)
        assert self.factor.moments is not None
        self._name, self._still = self.factor.moments.variable, self.factor.moments.still
        self._edges = np.linspace(low, high, cells + 1)
        self.values = (self._edges[:-1] + self._edges[1:]) / 2
        self._model, self._evaluator = model, Evaluator(model, {})
        self._posteriors = Posteriors(model, self._evaluator, cells)
        self._lanes = np.arange(cells)
        self.chances = np.zeros(cells)

    def start(self, state: State) -> None:
        """Begin with what the init says, given the visible variables of the one lane of ``state``."""
        init = next(i for i in self._model.inits if i.variable == self._name)
        frame = self._frame(state)
        self.chances = self._cells(init.dist, frame)[0]
        self._learn(self.factor.first, frame, self._spread(state))

    def advance(self, state: State, action: int, after: State, seen: State) -> None:
        """Take a step: the one lane of states has the visible variables."""
        frame = self._frame(state, after, action)
        if not self._still:
            update = next(u for u in self._model.updates if u.variable == self._name)
            self.chances = self.chances @ self._cells(update.dist, frame)
        self._learn(self.factor.evidence, frame, self._spread(seen))

    def moments(self) -> tuple[float, float]:
        """Return mean and deviation."""
        mean = float(self.chances @ self.values)
        return mean, float(np.sqrt(self.chances @ (self.values - mean) ** 2))

    def _frame(self, state: State, after: State | None = None, action: int = 0) -> Frame:
        codes = np.full(len(self._lanes), action)
        later = None if after is None else self._spread(after)
        return Frame(self._lanes, self._spread(state), after=later, action=codes)

    def _spread(self, state: State) -> State:
        found = {name: np.repeat(values, len(self._lanes), axis=0) for name, values in state.items()}
        return found | {self._name: self.values.astype(np.float32)} if self._name in found else found

    def _cells(self, dist: ir.Dist, frame: Frame) -> Array:
        """Return the probability of each cell, for each value of the float before: values by cells."""
        with np.errstate(all="ignore"):
            match dist:
                case ir.Certain():
                    value = np.broadcast_to(self._evaluator.value(dist.value, frame), self._lanes.shape)
                    place = np.searchsorted(self._edges, value[:, np.newaxis]) - 1
                    return (place == self._lanes).astype(np.float64)
                case ir.Continuous():
                    below = self._evaluator.below(dist, frame)
                    reach = np.asarray(below(self._edges[:, np.newaxis]))  # edges by values
                    return np.diff(np.broadcast_to(reach, (len(self._edges), len(self._lanes))), axis=0).T
                case ir.IfDist():
                    holds = np.broadcast_to(self._evaluator.value(dist.condition, frame), self._lanes.shape)
                    parts = self._cells(dist.then, frame), self._cells(dist.otherwise, frame)
                    return np.where(holds[:, np.newaxis], *parts)
        raise TypeError(f"no cells of {type(dist).__name__}")

    def _learn(self, pieces: tuple[ir.Evidence, ...], frame: Frame, seen: State) -> None:
        for evidence in pieces:
            for chance in self._posteriors.likelihood(evidence, 0, frame, seen):
                self.chances = self.chances * chance
        self.chances = self.chances / self.chances.sum()


def distances(model: ir.Model, grid: GridFilter, episodes: int, steps: int, seed: int) -> Array:
    """Return for each step of the default policy's episodes how far what it knows is from the grid's.

    A row has the difference of the means, in deviations of the grid's, and the deviations' ratio.
    """
    run, rows = Interpreter(model), []
    world = derive(seed, Stream.WORLD, 0)
    for number in range(episodes):
        draws = PhiloxDraws(world, np.full(1, number), 0)
        state = run.init_hidden(run.init_visible(draws), draws)
        history = run.init_history(state)
        grid.start(state)
        for time in range(steps):
            draws = PhiloxDraws(world, np.full(1, number), time)
            action = int(run.default_policy(state, draws, history)[0])
            done = run.step(state, action, draws)
            if done.terminal[0]:
                break
            key = run.observe(state, action, draws, done.after)
            history = run.advance_history(state, action, key, done.after, history)
            grid.advance(state, action, done.after, run.decode(key))
            mean, deviation = history[f"belief {grid.factor.element}"][0, 0].tolist()
            exact, spread = grid.moments()
            rows.append(((mean - exact) / spread, deviation / spread))
            state = done.after
    return np.array(rows)
