# SPDX-License-Identifier: Apache-2.0
"""Whole models: what a step does, what a key says, and what the filter makes of it."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import pytest
from support.ir_samples import const, rocks, tiger, wanderer

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.trace import columns, trace
from hypgen.dsl.types import BOOL

LANES = 20_000
SLIP = {"slip": [0.1, 0.3]}
ONE = 2**24


def draws(lanes: int = LANES, step: int = 0, key: tuple[int, int] = (1, 2)) -> PhiloxDraws:
    return PhiloxDraws(key, np.arange(lanes), step)


def start(interpreter: Interpreter) -> State:
    source = draws(interpreter.lanes)
    return interpreter.init_hidden(interpreter.init_visible(source), source)


def test_tiger_rewards_moves_and_growls() -> None:
    interpreter = Interpreter(tiger(), lanes=LANES)
    state = start(interpreter)
    where = state["room.tiger"]
    assert np.mean(where) == pytest.approx(0.5, abs=0.02)

    listened = interpreter.step(state, np.zeros(LANES, dtype=int), draws())
    assert np.array_equal(listened.after["room.tiger"], where)
    assert set(listened.reward.tolist()) == {-ONE}
    key = interpreter.observe(state, np.zeros(LANES, dtype=int), draws(), listened.after)
    assert np.mean(key[:, 0] == where) == pytest.approx(0.85, abs=0.02)

    opened = interpreter.step(state, np.ones(LANES, dtype=int), draws())
    assert np.array_equal(opened.reward, np.where(where == 0, -100, 10) * ONE)
    assert np.mean(opened.after["room.tiger"] == where) == pytest.approx(0.5, abs=0.02)
    assert not opened.terminal.any() and not opened.error.any()


def test_the_filter_of_tiger_is_bayes_rule() -> None:
    interpreter = Interpreter(tiger(), {"hearing": 0.75}, lanes=2)
    state: State = {"room.tiger": np.array([0, 1], dtype=np.int32)}
    weight, after = interpreter.filter(state, np.zeros(2, dtype=int), [0], draws(2))
    assert weight.tolist() == [0.75, 0.25]
    assert after["room.tiger"].tolist() == [0, 1]


def rock_state(x: int, *good: bool) -> State:
    return {"rover.x": np.array([x], dtype=np.int32), "rock.good": np.array([good])}


def test_rocks_are_sampled_only_where_they_are() -> None:
    interpreter = Interpreter(rocks())
    east, sample, check1 = 0, 2, 4
    away, here = rock_state(1, True, True), rock_state(2, True, True)
    assert interpreter.legal_actions(away)[:, 0].tolist() == [True, True, False, True, True]
    assert interpreter.is_legal(here, [sample]).tolist() == [True]

    taken = interpreter.step(here, [sample], draws(1))
    assert taken.after["rock.good"].tolist() == [[True, False]]
    assert taken.reward.tolist() == [10 * ONE]
    again = interpreter.step(taken.after, [sample], draws(1))
    assert again.reward.tolist() == [-10 * ONE]

    left = interpreter.step(here, [east], draws(1))
    assert (left.terminal.tolist(), left.success.tolist(), left.reward.tolist()) == (
        [True],
        [True],
        [10 * ONE],
    )
    weight, _ = interpreter.filter(here, [east], [0], draws(1))
    assert weight.tolist() == [0.0]

    for key, want in ((0, 0.0), (1, 1.0), (2, 0.0)):  # at the rock itself a check is exact
        weight, _ = interpreter.filter(here, [check1], [key], draws(1))
        assert weight.tolist() == [want]


def test_bounds_are_single_precision() -> None:
    interpreter = Interpreter(rocks())
    gamma = np.float32(0.95)
    bound = interpreter.upper(rock_state(1, True, True))
    assert bound.dtype == np.float32
    assert bound[0] == np.float32(10) * np.float32(float(gamma) ** 2) + np.float32(20)
    assert interpreter.lower(rock_state(1, True, True)).tolist() == [0.0]


def test_an_illegal_default_becomes_the_lowest_legal_action() -> None:
    sample_always = ir.Policy(
        (), ir.Certain(rocks().action.type, const(2)), ir.Site("policy:default"), rocks().action.span
    )
    model = dataclasses.replace(rocks(), policy=sample_always)
    interpreter = Interpreter(model)
    assert interpreter.default_policy(rock_state(1, True, True), draws(1)).tolist() == [0]
    assert interpreter.default_policy(rock_state(2, True, True), draws(1)).tolist() == [2]


def test_without_a_policy_legal_actions_are_equally_likely() -> None:
    model = dataclasses.replace(rocks(), policy=None)
    interpreter = Interpreter(model, lanes=LANES)
    state = start(interpreter)  # at x = 0, where rock 0 lies
    counts = np.bincount(interpreter.default_policy(state, draws(step=3)), minlength=5) / LANES
    assert counts == pytest.approx([0.2] * 5, abs=0.02)


def test_no_legal_action_gives_minus_one() -> None:
    nothing = dataclasses.replace(rocks(), legal=ir.Const(BOOL, False))
    assert Interpreter(nothing).default_policy(rock_state(0, True, True), draws(1)).tolist() == [-1]
    table = trace(nothing, 1, 3, 2)
    names = columns(nothing)
    assert not table[:, names.index("reward") :].any()
    assert set(table[:, names.index("action")].tolist()) == {-1}


def test_fixed_variables_stay_and_stages_see_what_earlier_ones_wrote() -> None:
    interpreter = Interpreter(wanderer(), SLIP, lanes=LANES)
    state = start(interpreter)
    go_both = np.full(LANES, 3)
    done = interpreter.step(state, go_both, draws(step=5))
    assert np.array_equal(done.after["map.wall"], state["map.wall"])
    moved = done.after["bot.at"] != state["bot.at"]
    assert not moved.all() and moved.any()
    # `seen` is noisy about the place after the move.
    assert np.mean(done.after["bot.seen"] == done.after["bot.at"]) == pytest.approx(0.75, abs=0.02)


def test_members_of_a_family_draw_independently() -> None:
    interpreter = Interpreter(wanderer(), SLIP, lanes=LANES)
    walls = start(interpreter)["map.wall"].astype(float)
    assert np.mean(walls, axis=0) == pytest.approx([0.25] * 5, abs=0.02)
    correlation = np.corrcoef(walls.T) - np.eye(5)
    assert np.abs(correlation).max() < 0.03


def test_the_first_component_of_a_product_action_is_the_most_significant() -> None:
    interpreter = Interpreter(wanderer(), {"slip": [0.0, 0.0]}, lanes=LANES)
    state = start(interpreter)
    only_first = interpreter.step(state, np.full(LANES, 2), draws(step=1)).after["bot.at"] != state["bot.at"]
    assert only_first[:, 0].any() and not only_first[:, 1].any()


def test_weights_of_all_keys_sum_to_one() -> None:
    """Every key's weight is its probability, so over all keys a particle's weights add up to 1."""
    lanes = 50
    model = dataclasses.replace(wanderer(), terminal=ir.Const(BOOL, False))
    interpreter = Interpreter(model, SLIP, lanes=lanes)
    state = start(interpreter)
    total = np.zeros(lanes)
    for key in range(3**2 * 5**2):
        weight, after = interpreter.filter(state, np.full(lanes, 3), [key], draws(lanes))
        total += weight
        first_seen, second_seen = divmod(key % 25, 5)
        assert set(after["bot.seen"][:, 0]) == {first_seen + 1}
        assert set(after["bot.seen"][:, 1]) == {second_seen + 1}
    assert total == pytest.approx(np.ones(lanes), abs=1e-9)


def test_a_key_packs_the_digits_that_the_step_gave() -> None:
    interpreter = Interpreter(wanderer(), SLIP, lanes=200)
    state = start(interpreter)
    action = np.arange(200) % 4
    done = interpreter.step(state, action, draws(200))
    key = interpreter.observe(state, action, draws(200), done.after)[:, 0]
    seen = done.after["bot.seen"].astype(np.uint64) - np.uint64(1)
    assert np.array_equal(key % 25, seen[:, 0] * np.uint64(5) + seen[:, 1])


@pytest.mark.parametrize(("model", "params"), [(tiger(), None), (rocks(), None), (wanderer(), SLIP)])
def test_traces_do_not_depend_on_the_number_of_lanes(model: ir.Model, params: Any) -> None:
    large, small = trace(model, 7, 40, 30, params), trace(model, 7, 3, 30, params)
    assert large.shape[1] == len(columns(model))
    assert np.array_equal(large.reshape(30, 40, -1)[:, :3], small.reshape(30, 3, -1))
    assert not np.array_equal(trace(model, 8, 3, 30, params), small)


def test_a_lane_that_ended_starts_again() -> None:
    model, lanes = rocks(), 200
    names = columns(model)
    rows = trace(model, 3, lanes, 40).reshape(40, lanes, -1)
    terminal = rows[..., names.index("terminal")].astype(bool)
    assert terminal.any()
    assert not rows[terminal][:, names.index("key")].any()
    assert not rows[terminal][:, names.index("weight") :].any()
    source = derive(3, 3, 0)
    for t, lane in itertools.islice(zip(*np.nonzero(terminal[:-1]), strict=True), 20):
        fresh = PhiloxDraws(source, [lane], t + 1)
        interpreter = Interpreter(model)
        state = interpreter.init_hidden(interpreter.init_visible(fresh), fresh)
        assert rows[t + 1, lane, :3].tolist() == [0, *state["rock.good"][0].tolist()]


def test_a_reward_that_is_not_a_number_is_reported() -> None:
    bad = dataclasses.replace(tiger().rewards[0], value=const(float("nan")))
    step = Interpreter(dataclasses.replace(tiger(), rewards=(bad,))).step(
        {"room.tiger": np.zeros(1, dtype=np.int32)}, [0], draws(1)
    )
    assert step.error.tolist() == [True] and step.reward.tolist() == [0]
