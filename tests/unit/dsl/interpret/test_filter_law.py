# SPDX-License-Identifier: Apache-2.0
"""The filter's law: weighting what it draws gives the same posterior as throwing away what was not seen.

Each model is a trap in which a filter with slightly wrong rules is biased although sampler and filter agree
on every bit.
"""

from __future__ import annotations

import numpy as np
import pytest

from hypgen.dsl import ir
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse

LANES = 400_000
HEAD = "model Trap\ndiscount 0.9\naction act: 1 .. 2\nreward none = 0\npolicy default = 1\n"

TRAPS = {
    # The draw that moved the visible variable also wears the hidden one.
    "shared_draw": """
      element car {
        visible x: 0 .. 3   hidden worn: bool
        init x = 0          init worn ~ bernoulli(0.3)
        let works ~ bernoulli(0.6)
        x' = if works then clamp(x + act) else x
        worn' = worn or not works
      }""",
    # Weights that sum to more than 1: the sampler gives b only what a leaves.
    "clipped_table": """
      enum Sign { a, b, c }
      param p: prob = 0.7
      element box {
        hidden full: bool
        init full ~ bernoulli(0.5)
        full' = full
      }
      observe sign: Sign ~ if box.full' then { a: p, b: 0.6, else c } else { a: 0.2, b: 0.2, else c }""",
    # Ranges that do not start at 0, a reading whose quality depends on what is hidden.
    "hidden_quality": """
      type Level = 1 .. 3
      element tank {
        hidden level: Level
        init level ~ uniform(Level)
        level' ~ noisy(level, 0.8)
      }
      observe gauge: Level ~ noisy(tank.level', 0.4 + 0.15 * tank.level')""",
    # A visible variable drawn from what is hidden, and one drawn from visible state alone.
    "visible_draws": """
      type Place = 0 .. 4
      element target {
        hidden at: Place
        init at ~ uniform(Place)
        at' ~ uniform(p in Place where abs(p - at) <= 1: p)
      }
      element robot {
        visible near: bool   visible slipped: bool
        init near = false    init slipped = false
        near' ~ noisy(target.at' <= 1, 0.75)
        slipped' ~ bernoulli(if near then 0.5 else 0.2)
      }""",
    # Members of a family see through sensors of their own.
    "family": """
      type Bot = 1 .. 2
      element door { hidden open: bool  init open ~ bernoulli(0.4)  open' = open }
      element bot[b in Bot] { observe sees: bool ~ noisy(door.open', if act == b then 0.9 else 0.6) }""",
}


def model_of(text: str) -> ir.Model:
    source = Source("trap.pomdp", HEAD + text)
    file = parse(source)
    assert isinstance(file, ast.ModelFile)
    return lower(file, {}, source)


def hidden_codes(model: ir.Model, state: dict) -> np.ndarray:
    """Return one number for the values of all hidden variables of each lane."""
    code = np.zeros(LANES, dtype=np.int64)
    for variable in model.variables:
        if not variable.visible:
            code = code * 8 + state[variable.name].reshape(LANES).astype(np.int64)
    return code


@pytest.mark.parametrize("trap", TRAPS)
@pytest.mark.parametrize("action", [0, 1])
def test_weighting_equals_rejection(trap: str, action: int) -> None:
    model = model_of(TRAPS[trap])
    interpreter = Interpreter(model, lanes=LANES)
    lanes = np.arange(LANES)
    world, belief = (PhiloxDraws(derive(1, Stream.TEST, n), lanes, 0) for n in (0, 1))
    start = interpreter.init_hidden(interpreter.init_visible(world), world)
    after = interpreter.step(start, np.full(LANES, action), world).after
    keys = interpreter.observe(start, np.full(LANES, action), world, after)[:, 0]
    truth = hidden_codes(model, after)
    again = interpreter.init_hidden(interpreter.init_visible(belief), belief)
    for key in np.unique(keys):
        seen = truth[keys == key]
        weight, filtered = interpreter.filter(again, np.full(LANES, action), [key], belief)
        assert weight.sum() > 0
        drawn = hidden_codes(model, filtered)
        effective = weight.sum() ** 2 / (weight**2).sum()
        for code in np.union1d(seen, drawn):
            rejected = np.mean(seen == code)
            weighted = weight[drawn == code].sum() / weight.sum()
            spread = np.sqrt(max(rejected * (1 - rejected), 1e-4) * (1 / len(seen) + 1 / effective))
            assert abs(rejected - weighted) < 5 * spread, (key, code, rejected, weighted)


# What is seen at the start, which a hidden init may read in turn.
FIRST_LOOKS = {
    "sensors": """
      type Level = 1 .. 3
      element tank {
        hidden level: Level   hidden stuck: bool
        init level ~ uniform(Level)
        init stuck ~ bernoulli(if gauge > 1 then 0.7 else 0.2)
        level' = level   stuck' = stuck
        observe gauge: Level at start ~ noisy(level, 0.4 + 0.15 * level)
        observe alarm: bool at start = stuck and level == 3
      }""",
    "members": """
      type Bot = 0 .. 2
      element bot[b in Bot] {
        hidden at: 0 .. 3   visible seen: bool
        init at ~ if b > 0 and bot[b - 1].seen then { bot[b - 1].at: 0.5, else 0 } else uniform(0, 3)
        init seen ~ noisy(at > 1, 0.8)
        at' = at            seen' = seen
      }""",
}


@pytest.mark.parametrize("look", FIRST_LOOKS)
def test_the_first_weights_equal_rejection(look: str) -> None:
    model = model_of(FIRST_LOOKS[look])
    interpreter = Interpreter(model, lanes=LANES)
    lanes = np.arange(LANES)
    world, belief = (PhiloxDraws(derive(1, Stream.TEST, n), lanes, 0) for n in (0, 1))
    start = interpreter.init_hidden(interpreter.init_visible(world), world)
    names = [v.name for v in model.variables if v.visible]

    def hidden(state: dict) -> np.ndarray:
        parts = [state[v.name].reshape(LANES, -1) for v in model.variables if not v.visible]
        return np.concatenate(parts, axis=1).astype(np.int64) @ 8 ** np.arange(sum(p.shape[1] for p in parts))

    def visible(state: dict) -> np.ndarray:
        return np.concatenate([state[n].reshape(LANES, -1) for n in names], axis=1).astype(np.int64)

    truth, looks = hidden(start), visible(start)
    for look_seen in np.unique(looks, axis=0):
        same = (looks == look_seen).all(axis=1)
        one = int(np.argmax(same))
        given = {n: np.repeat(v[one : one + 1], LANES, axis=0) if n in names else v for n, v in start.items()}
        drawn = interpreter.init_hidden(given, belief)
        weight = interpreter.init_likelihood(drawn)
        effective = weight.sum() ** 2 / (weight**2).sum()
        codes = hidden(drawn)
        for code in np.unique(truth[same]):
            rejected, weighted = np.mean(truth[same] == code), weight[codes == code].sum() / weight.sum()
            spread = np.sqrt(max(rejected * (1 - rejected), 1e-4) * (1 / same.sum() + 1 / effective))
            assert abs(rejected - weighted) < 5 * spread, (look_seen, code, rejected, weighted)
