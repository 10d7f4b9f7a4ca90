# SPDX-License-Identifier: Apache-2.0
"""Sampling a model to find what no reading of its text can prove: ``hypgen check --samples``."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, History, State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Step, pick_legal
from hypgen.dsl.interpret.sampling.findings import Finding, Findings
from hypgen.dsl.interpret.sampling.sample_bounds import BoundsCheck
from hypgen.dsl.interpret.sampling.watched_interpreter import WatchedInterpreter
from hypgen.dsl.interpret.value_text import action_text
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.messages import c_sampling, w_warnings

_CHOICE_SITE = ir.Site("check:choice").id
_ACTION_SITE = ir.Site("check:action").id
_KEPT_SITE = ir.Site("check:kept").id

# Bounds on the lanes: few enough for episodes to grow long, many enough to be worth numpy's calls.
_LEAST_LANES, _MOST_LANES, _MOST_ENTRIES = 64, 4096, 4_000_000
# Steps to wonder about a reward that none of them paid; one that reads what a step leads to may be rare.
_ENOUGH_STEPS, _ENOUGH_FOR_RARE = 1000, 100_000
_KEPT_A_STEP, _KEPT_STEPS = 2, 128
# Parts of the time after which the walk, densities, returns and a second look at suspicious returns end.
WALKING, WEIGHING, PLAYING, CONFIRMING = 0.5, 0.75, 0.9, 1.0

Progress = Callable[[str, int, int], None]


class Visit(NamedTuple):
    """A visited state with what the agent had kept, the time, and the step that was taken from it."""

    state: State
    history: History
    time: int
    action: int
    after: State | None  # None: the step was terminal


class Walk:
    """Random episodes of a model, half of them near the default policy; every step is checked.

    ``seed`` decides everything but where the time limit of ``seconds`` ends it: that depends on the machine.
    ``visited`` and ``findings`` are good at any time, after an interrupt too.
    """

    def __init__(self, model: ir.Model, samples: int, seed: int, seconds: float = math.inf) -> None:
        self._start = clock.monotonic()
        self._seconds = seconds
        self.cut: list[str] = []  # what the time limit left unfinished, in words
        self.model = model
        self.samples = samples
        self.seed = seed
        self.visited = 0
        self.episodes = 0
        self.steps = 0  # taken from visited states
        self.visits: list[Visit] = []
        self._findings = Findings(model)
        self.least_reward = 0.0
        most = max(_LEAST_LANES, min(_MOST_LANES, _MOST_ENTRIES // model.action.count))
        self.lanes = max(1, min(samples, max(_LEAST_LANES, min(most, samples // 100))))
        self._interpreter = WatchedInterpreter(model, self._findings, lanes=self.lanes)
        self._bounds = BoundsCheck(model, self._findings)

    def is_over(self, share: float) -> bool:
        """Return whether this share of the time has passed."""
        return clock.monotonic() - self._start > share * self._seconds

    @property
    def findings(self) -> list[Finding]:
        """Return what was found so far, in the order of the model's text."""
        return self._findings.all()

    @property
    def collected(self) -> Findings:
        """Return where further checks add their findings."""
        return self._findings

    def run(self, progress: Progress) -> None:
        """Visit as many states as wanted; ``progress`` is told of each batch."""
        run, lanes = self._interpreter, np.arange(self.lanes)
        key, own = derive(self.seed, Stream.TEST, 2), derive(self.seed, Stream.TEST, 3)
        starts = _Starts(run, key)
        state, history = starts.take(self.lanes)
        time = np.zeros(self.lanes, dtype=np.int64)
        self.episodes = self.lanes
        t = 0
        while self.visited < self.samples:
            if self.visited and self.is_over(WALKING):
                self.cut.append(f"the walk ended after {self.visited:,} of {self.samples:,} states")
                break
            draws, words = PhiloxDraws(key, lanes, t), PhiloxDraws(own, lanes, t)
            run.watch.active = lanes < self.samples - self.visited
            run.check_invariants(state)
            action = self._act(state, history, draws, words)
            stuck = action < 0
            taken = np.where(stuck, 0, action)
            run.watch.active = run.watch.active & ~stuck
            self._bounds.add(state, history, run.watch.active)
            self.steps += int(run.watch.active.sum())
            step = run.step(state, taken, draws)
            run.watch.active = run.watch.active & ~step.terminal
            earned = step.reward[run.watch.active | step.terminal & ~stuck]
            least = float(earned.min(initial=0)) * 2.0**-self.model.reward_bits
            self.least_reward = min(self.least_reward, least)
            seen = run.observe(state, taken, draws, step.after)
            self._keep(state, history, time, taken, stuck, step, words)
            self.visited += min(self.lanes, self.samples - self.visited)
            t, time = t + 1, time + 1
            ended = stuck | step.terminal
            if self.model.horizon is not None:
                ended |= time >= self.model.horizon
            kept = run.advance_history(state, taken, seen, step.after, history)
            state, history = step.after, kept
            if ended.any():
                self.episodes += int(ended.sum())
                fresh, begun = starts.take(int(ended.sum()))
                state, history = _replaced(state, ended, fresh), _replaced(history, ended, begun)
                time = np.where(ended, 0, time)
            progress("walking", self.visited, self.samples)
        self._bounds.flush()
        self._judge_rewards()

    def _judge_rewards(self) -> None:
        """Add a finding for each reward that was never paid, unless it cannot be or little was seen."""
        functions = {f.name: f for f in self.model.functions}
        lets = {x.name: x for x in self.model.lets}
        for reward in self.model.rewards:
            if reward.name in self._interpreter.paid or operators.ends(reward.value.type) == (0, 0):
                continue
            reads = (node for node, _ in reached((reward.value,), functions, lets))
            looks_ahead = any(isinstance(node, ir.StateRead) and node.primed for node in reads)
            if self.steps >= (_ENOUGH_FOR_RARE if looks_ahead else _ENOUGH_STEPS):
                self._findings.add_whole(w_warnings.never_paid(reward.name, self.steps, reward.span))

    def _act(self, state: State, history: History, draws: PhiloxDraws, words: PhiloxDraws) -> Array:
        """Return each lane's action, -1 where none is legal; half of the lanes mostly follow the policy."""
        run, model = self._interpreter, self.model
        legal = run.legal_actions(state)
        possible = legal.any(axis=0)
        run.note(
            "legal",
            lambda _, span: c_sampling.no_legal_action(span),
            ~possible,
            state,
            history,
        )
        explore = pick_legal(legal, words.word(_ACTION_SITE, 0))
        if model.policy is None:
            return explore
        with run.watch.only(run.watch.active & possible):
            choice = run.policy_choice(model.policy, state, draws, history)
            allowed = np.take_along_axis(legal, choice[np.newaxis], axis=0)[0]
            run.note(
                "policy",
                lambda lane, span: w_warnings.illegal_choice(self._name(choice[lane]), span),
                ~allowed,
                state,
                history,
            )
        # Half of the lanes stay near the policy, the other half stray from it.
        mostly = np.where(np.arange(self.lanes) % 2 == 0, 0.9, 0.2)
        follow = allowed & (words.word(_CHOICE_SITE, 0) < (mostly * 2.0**32).astype(np.uint64))
        return np.where(follow, choice, explore)

    def _name(self, action: int) -> str:
        return action_text(int(action), self.model.action)

    def _keep(
        self,
        state: State,
        history: History,
        time: Array,
        action: Array,
        stuck: Array,
        step: Step,
        words: PhiloxDraws,
    ) -> None:
        """Remember a few of the visited states for the checks that repeat a step many times."""
        stride = 1 + self.samples // (self.lanes * _KEPT_STEPS)
        if self.visited // self.lanes % stride:
            return
        for n in range(_KEPT_A_STEP):
            lane = int(words.word(_KEPT_SITE, n)[0] * np.uint64(self.lanes) >> np.uint64(32))
            if stuck[lane]:
                continue
            self.visits.append(
                Visit(
                    _lane(state, lane),
                    _lane(history, lane),
                    int(time[lane]),
                    int(action[lane]),
                    None if step.terminal[lane] else _lane(step.after, lane),
                )
            )


class _Starts:
    """States at the start of episodes, drawn many at a time and taken as needed."""

    def __init__(self, run: WatchedInterpreter, key: tuple[int, int]) -> None:
        self._run = run
        self._key = key
        self._round = 0
        self._taken = run.lanes
        self._state: State = {}
        self._history: History = {}

    def take(self, count: int) -> tuple[State, History]:
        """Return states and histories of ``count`` new episodes, at most as many as there are lanes."""
        run = self._run
        if self._taken + count > run.lanes:
            draws = PhiloxDraws(self._key, np.arange(run.lanes), self._round)
            with run.watch.only(np.asarray(np.True_)):
                self._state = run.init_hidden(run.init_visible(draws), draws)
                self._history = run.init_history(self._state)
            self._round, self._taken = self._round + 1, 0
        chosen = slice(self._taken, self._taken + count)
        self._taken += count
        taken = ({n: v[chosen] for n, v in x.items()} for x in (self._state, self._history))
        return next(taken), next(taken)


def _lane(arrays: State, lane: int) -> State:
    return {name: values[lane].copy() for name, values in arrays.items()}


def _replaced(values: State, where: Array, by: State) -> State:
    result = {name: value.copy() for name, value in values.items()}
    for name, value in result.items():
        value[where] = by[name]
    return result
