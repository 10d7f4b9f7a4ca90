# SPDX-License-Identifier: Apache-2.0
"""Factors: which hidden variables are independent, and that their posteriors are those of Bayes' rule."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest
from support.factored_models import FACTORED, HEAD, model_of
from support.paths import EXAMPLES

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, Frame, State, combinations
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.posteriors import Posterior
from hypgen.dsl.load import load
from hypgen.dsl.types import low_of, size_of


@pytest.mark.parametrize(
    ("example", "element", "members", "size"),
    [
        ("rock_sample", "rock", 8, 2),
        ("two_robot_rock_sample", "rock", 20, 2),
        ("tiger", "room", 1, 2),
        ("tag", "opponent", 1, 50),
    ],
)
def test_examples_factor(example: str, element: str, members: int, size: int) -> None:
    model = load(EXAMPLES / f"{example}.pomdp").model
    (factor,) = model.factors
    assert (factor.element, factor.members, factor.size) == (element, members, size)
    assert model.factored and not factor.inexact


class Enumerated:
    """The exact filter over all joint values of the hidden variables, which knows nothing of factors.

    A lane of an interpreter is a joint value; transitions and observations are weighed by their densities.
    """

    def __init__(self, model: ir.Model, start: State) -> None:
        places = [(v, p) for v in model.variables if not v.visible for p in np.ndindex(*shape_of(v))]
        values = [range(low_of(v.type), low_of(v.type) + size_of(v.type)) for v, _ in places]
        joint = np.array(list(itertools.product(*values)))
        self.model, self.lanes = model, len(joint)
        self.interpreter = Interpreter(model, lanes=self.lanes)
        self.hidden = {v.name: np.zeros((self.lanes, *shape_of(v)), int) for v, _ in places}
        for column, (v, place) in enumerate(places):
            self.hidden[v.name][(slice(None), *place)] = joint[:, column]
        state = self.state(start)
        frame = self.interpreter._frame(state)
        inits = [i for i in model.inits if i.variable in self.hidden or i in model.first_seen]
        weights = np.prod([self.density(i.binders, i.dist, frame, state[i.variable]) for i in inits], axis=0)
        self.weights = weights / weights.sum()

    def state(self, visible: State) -> State:
        """Return the states that agree with ``visible``, one for each joint value."""
        return {
            name: self.hidden[name].astype(values.dtype)
            if name in self.hidden
            else np.repeat(values[:1], self.lanes, axis=0)
            for name, values in visible.items()
        }

    def density(
        self, binders: tuple[ir.Binder, ...], dist: ir.Dist, frame: Frame, values: Array
    ) -> npt.NDArray[np.float64]:
        """Return the density of a declaration's values in each lane."""
        result = np.ones(self.lanes)
        for number, _, bound in combinations(binders):
            value = values.reshape(self.lanes, -1)[:, number]
            result *= self.interpreter._evaluator.density(dist, frame.bind(bound), value)
        return result

    def advance(self, visible: State, action: Array, key: Array, after: State) -> None:
        """Take in a step that was not terminal."""
        goals, before = self.state(after), self.state(visible)
        seen = self.interpreter.decode(np.asarray(key))
        totals = np.zeros(self.lanes)
        for h in np.flatnonzero(self.weights):
            state = {n: np.repeat(v[h : h + 1], self.lanes, axis=0) for n, v in before.items()}
            frame = self.interpreter._frame(state, after=goals, action=action)
            weight = np.full(self.lanes, self.weights[h])
            for name in (v.name for v in self.model.variables if v.fixed):
                weight *= (state[name] == goals[name]).reshape(self.lanes, -1).all(axis=1)
            for u in self.model.updates:
                weight *= self.density(u.binders, u.dist, frame, goals[u.variable])
            for o in self.model.observations:
                weight *= self.density(o.binders, o.dist, frame, seen[o.name])
            totals += np.where(self.interpreter._evaluator.value(self.model.terminal, frame), 0.0, weight)
        self.weights = totals / totals.sum()


def shape_of(variable: ir.Variable) -> tuple[int, ...]:
    return tuple(size_of(t) for t in variable.indices)


@pytest.mark.parametrize("name", FACTORED)
def test_posteriors_are_those_of_enumeration(name: str) -> None:
    model = model_of(FACTORED[name])
    assert model.factored and all(f.exact for f in model.factors), model.obstacles
    for seed in range(3):
        follow(model, seed)


def follow(model: ir.Model, seed: int) -> None:
    """Compare both posteriors along an episode."""
    interpreter, random = Interpreter(model), np.random.default_rng(seed)
    key = derive(seed, Stream.TEST, 0)
    draws = PhiloxDraws(key, np.arange(1), 0)
    state = interpreter.init_hidden(interpreter.init_visible(draws), draws)
    exact, posterior = Enumerated(model, state), interpreter.init_posterior(state)
    for t in range(10):
        compare(exact, posterior)
        action = np.array([random.integers(4)])
        draws = PhiloxDraws(key, np.arange(1), t)
        after, _, terminal, _, _ = interpreter.step(state, action, draws)
        if terminal[0]:
            return
        seen = interpreter.observe(state, action, draws, after)
        exact.advance(state, action, seen, after)
        posterior, possible = interpreter.advance_posterior(state, action, seen, after, posterior)
        assert possible.all()
        state = after


def compare(exact: Enumerated, posterior: Posterior) -> None:
    """Check that a factor's posterior is the marginal of the joint one."""
    for factor in exact.model.factors:
        of = exact.interpreter._posteriors
        for member in range(factor.members):
            codes = of.code(factor, member, exact.hidden)
            expected = np.bincount(codes, weights=exact.weights, minlength=factor.size)
            assert np.allclose(posterior[factor.element][0, member], expected, atol=1e-12, rtol=0)


# Models that do not factor: the element that cannot, the line of the read, and what explains it.
COUPLED = {
    "a hidden robot reads the map": (
        """
      type Cell = 0 .. 3
      element map { hidden fixed wall: bool[Cell]  init wall ~ [c in Cell: bernoulli(0.2)] }
      element robot {
        hidden cell: Cell
        init cell = 0
        cell' = if map.wall[cell] then 0 else clamp(cell + 1)
      }
      observe bump: bool ~ noisy(map.wall[robot.cell'], 0.9)""",
        ["map", "robot"],
        "the update of 'robot.cell' reads 'map.wall', hidden state of another element",
        "map.wall[cell]",
    ),
    "an observation couples robot and target": (
        """
      type Cell = 0 .. 3
      element robot { hidden cell: Cell  init cell ~ uniform(Cell)  cell' = cell }
      element target { hidden cell: Cell  init cell ~ uniform(Cell)  cell' = cell }
      fn close(): bool = robot.cell == target.cell
      observe near: bool ~ noisy(close()', 0.9)""",
        ["robot", "target"],
        "'observe near' reads 'robot.cell' and 'target.cell' at once",
        "robot.cell",
    ),
    "a first look couples robot and target": (
        """
      type Cell = 0 .. 3
      element robot { hidden cell: Cell  init cell ~ uniform(Cell)  cell' = cell }
      element target {
        hidden cell: Cell  init cell ~ uniform(Cell)  cell' = cell
        observe near: bool at start ~ noisy(cell == robot.cell, 0.9)
      }""",
        ["robot", "target"],
        "the init of 'target.near' reads 'target.cell' and 'robot.cell' at once",
        "robot.cell",
    ),
    "an index is hidden": (
        """
      type Box = 0 .. 2
      element box[b in Box] { hidden full: bool  init full ~ bernoulli(0.5)  full' = full  hidden next: Box
        init next ~ uniform(Box)  next' = next }
      observe full: bool ~ noisy(box[box[0].next].full', 0.9)""",
        ["box"],
        "'observe full' reads 'box.full' through an index that is not known",
        "box[box[0].next].full'",
    ),
    "an observation sums up a family": (
        """
      type Box = 0 .. 2
      element box[b in Box] { hidden full: bool  init full ~ bernoulli(0.5)  full' = full }
      observe number: 0 .. 3 = count(b in Box where box[b].full')""",
        ["box"],
        "'observe number' reads 'box.full' of several members",
        "box[b].full'",
    ),
    "a draw moves two": (
        """
      type Box = 0 .. 2
      element sea { let wind ~ bernoulli(0.5) }
      element box[b in Box] { hidden open: bool  init open = false  open' = open or sea.wind }""",
        ["box"],
        "the draw 'sea.wind' ties what reads it: the update of 'box.open'",
        "sea.wind",
    ),
    "members follow each other": (
        """
      type Box = 0 .. 2
      element box[b in Box] { hidden open: bool  init open ~ bernoulli(0.5)  open' = box[0].open }""",
        ["box"],
        "the update of 'box.open' reads 'box.open' of another member of the family",
        "box[0].open",
    ),
}


@pytest.mark.parametrize("name", COUPLED)
def test_coupled_elements_are_named_with_the_read_that_couples_them(name: str) -> None:
    text, elements, reason, read = COUPLED[name]
    model = model_of(text)
    assert not model.factored
    assert [o.element for o in model.obstacles] == elements
    first = model.obstacles[0]
    assert first.reason == reason
    assert (HEAD + text).splitlines()[first.span.line - 1][first.span.column - 1 :].startswith(read)


# Factors without a finite posterior: a draw that is read twice, too many values.
PARTICLES = {
    "the draw 'car.works' is read": """
      element car {
        let works ~ bernoulli(0.9)
        hidden worn: bool   hidden stuck: bool
        init worn = false   init stuck = false
        worn' = worn or works
        stuck' = not works
      }""",
    "it has more than 512 joint values": """
      type Place = 0 .. 599
      element car { hidden place: Place  init place = 0  place' ~ noisy(place, 0.5) }""",
    "it has more than 4096 joint values": """
      type Bit = 1 .. 13
      element car { hidden on: bool[Bit]  init on ~ [b in Bit: bernoulli(0.5)]  on' = [b in Bit: on[b]] }""",
    "'car.place' is a float": """
      element car { hidden place: float  init place = 0.5  place' = clamp(place + 0.5, 0.0, 9.0) }""",
}


@pytest.mark.parametrize("reason", PARTICLES)
def test_factors_without_an_exact_posterior_say_why(reason: str) -> None:
    model = model_of(PARTICLES[reason])
    assert model.factored
    assert [f.inexact for f in model.factors] == [reason]


def test_coupled_elements_are_one_factor_beside_an_independent_one() -> None:
    text = COUPLED["an observation couples robot and target"][0]
    model = model_of(text + "element rock { hidden good: bool  init good ~ bernoulli(0.5)  good' = good }")
    assert [(f.element, f.joined) for f in model.factors] == [("rock", False), ("robot_and_target", True)]
    assert model.factored
    assert [o.element for o in model.obstacles] == ["robot", "target"]
    joined = model.factors[1]
    assert set(joined.variables) == {v.name for v in model.variables if v.element in ("robot", "target")}
    assert not joined.exact


def test_maps_that_copies_draw_again_stay_in_the_whole_state() -> None:
    model = model_of(
        """
      type Cell = 0 .. 3
      element floor { hidden fixed wet: bool[Cell]  init wet ~ [c in Cell: bernoulli(0.3)] }
      element robot { hidden at: Cell  init at ~ uniform(Cell)  at' = at }
      element rock { hidden good: bool  init good ~ bernoulli(0.5)  good' = good }
      observe damp: bool ~ noisy(floor.wet[robot.at'], 0.9)"""
    )
    assert [f.element for f in model.factors] == ["rock"]
    assert not model.factored
