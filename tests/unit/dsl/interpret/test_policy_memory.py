# SPDX-License-Identifier: Apache-2.0
"""What a policy remembers: the meaning of memory, ``last`` and the policy's own draws."""

from __future__ import annotations

import numpy as np
import pytest

from hypgen.dsl import ir
from hypgen.dsl.interpret.floats.philox import PhiloxDraws
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.trace import columns, trace
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

LEFT, RIGHT = 0, 1
LISTEN, OPEN_LEFT, OPEN_RIGHT = 0, 1, 2
TIGER = """
model TigerMemory
enum Door { left, right }
enum Act { listen, open_left, open_right }
discount 0.95
action act: Act
element room {
  hidden tiger: Door
  init tiger ~ uniform(Door)
  tiger' ~ if act == listen then tiger else uniform(Door)
}
observe heard: Door ~ if act == listen then noisy(room.tiger', 0.85) else uniform(Door)
reward outcome = if act == listen then -1 else if (act == open_left) == (room.tiger == left) then -100 else 10
policy default {
  memory lead: -2 .. 2 = 0
  let n = if last(act, open_left) != listen then 0
          else if last(heard, left) == left then lead + 1 else lead - 1
  lead' = clamp(n)
  choose = if n >= 2 then open_right else if n <= -2 then open_left else listen
}
bound upper = 10 / (1 - gamma)
bound tail = -1 / (1 - gamma)
"""
HALL = """
model Hall
type Lamp = 0 .. 2
type Side = -1 .. 1
enum Move { stay, go(Side) }
discount 0.9
action move: Move[Lamp]
element hall {
  visible at: Lamp
  init at ~ uniform(Lamp)
  at' ~ uniform(Lamp)
}
element lamp[k in Lamp] {
  hidden on: bool
  init on ~ bernoulli(0.5)
  on' ~ if move[k] == stay then on else bernoulli(0.5)
  observe shade: Side[Side] ~ [s in Side: noisy(if on' then s else 0, 0.9)]
}
reward lit = count(k in Lamp where lamp[k].on)
policy default {
  memory dark: bool[Lamp] = hall.at == 1
  memory seen: 0 .. 9[Lamp, Side] = [k in Lamp, s in Side: k]
  memory start: Lamp = hall.at
  let lucky ~ bernoulli(0.25)
  let again = lucky and start == hall.at
  dark' = [k in Lamp: last(lamp[k].shade[1], 0) == -1 or (dark[k] and last(move[k], stay) == stay)]
  seen' = [k in Lamp, s in Side: clamp(seen[k, s] + last(lamp[k].shade[s], 1))]
  start' = start
  choose ~ [k in Lamp: if again or dark[k] then uniform(Move) else if seen[k, 0] > 4 then stay
            else {go(last(lamp[start].shade[0], -1)): 0.75, else last(move[k], go(1))}]
}
bound lower = 0.5 * start - count(k in Lamp where dark[k] and last(move[k], stay) == stay)
"""


def model_of(text: str) -> ir.Model:
    source = Source("test.pomdp", text)
    return lower(parse(source), {}, source)


def test_the_policy_sees_what_was_before_and_memory_follows() -> None:
    interpreter = Interpreter(model_of(TIGER))
    state = {"room.tiger": np.array([LEFT], dtype=np.int32)}
    draws = PhiloxDraws((1, 2), np.arange(1), 0)
    history = interpreter.init_history(state)
    chosen, leads = [], []
    for heard in (LEFT, RIGHT, LEFT, LEFT, RIGHT, LEFT):
        action = interpreter.default_policy(state, draws, history)
        chosen.append(int(action[0]))
        history = interpreter.advance_history(state, action, np.array([heard], np.uint64), state, history)
        leads.append(int(history["memory lead"][0]))
    # Memory is what the policy knew when it chose: it lags one growl behind.
    assert chosen == [LISTEN, LISTEN, LISTEN, LISTEN, OPEN_RIGHT, LISTEN]
    assert leads == [0, 1, 0, 1, 2, 0]


def test_the_policy_alone_earns_what_it_should() -> None:
    lanes, steps = 4000, 90
    interpreter = Interpreter(model_of(TIGER), lanes=lanes)
    start = PhiloxDraws((3, 4), np.arange(lanes), 0)
    state = interpreter.init_hidden(interpreter.init_visible(start), start)
    history = interpreter.init_history(state)
    total = np.zeros(lanes)
    for t in range(steps):
        draws = PhiloxDraws((3, 4), np.arange(lanes), t)
        action = interpreter.default_policy(state, draws, history)
        step = interpreter.step(state, action, draws)
        total += 0.95**t * step.reward / 2**24
        key = interpreter.observe(state, action, draws, step.after)
        history = interpreter.advance_history(state, action, key, step.after, history)
        state = step.after
    assert np.mean(total) == pytest.approx(19.4, abs=4 * np.std(total) / lanes**0.5)


def test_only_what_is_read_is_kept() -> None:
    kept = model_of(TIGER).history
    assert [r.name for r in kept.registers] == ["lead"]
    assert kept.observations == ("heard",)
    assert kept.action
    plain = model_of(TIGER[: TIGER.index("policy")] + "policy default = listen\nbound upper = 200\n")
    assert plain.history.is_empty


def test_arrays_families_products_and_draws() -> None:
    model = model_of(HALL)
    assert model.history.observations == ("lamp.shade",)
    assert model.policy is not None
    assert [(x.name, x.site.path) for x in model.policy.lets] == [
        ("policy.lucky", "policy:lucky"),
        ("policy.again", "policy:again"),
    ]
    interpreter = Interpreter(model, lanes=2)
    draws = PhiloxDraws((1, 2), np.arange(2), 0)
    state = interpreter.init_visible(draws)
    state["hall.at"] = np.array([1, 2], dtype=np.int32)
    history = interpreter.init_history(state)
    assert history["memory dark"].tolist() == [[True] * 3, [False] * 3]
    assert history["memory seen"][0].tolist() == [[0] * 3, [1] * 3, [2] * 3]
    assert history["memory start"].tolist() == [1, 2]
    assert interpreter.lower(state, history).tolist() == [-2.5, 1.0]

    shades = np.array([[-1, 0, 1], [0, 0, 1], [1, 1, -1]])  # by lamp, then side
    digits = np.concatenate([(shades + 1).ravel(), [0]])
    key = 0
    for digit in digits:
        key = key * 3 + int(digit)
    action = (0 * 4 + 1) * 4 + 3  # stay, go(-1), go(1)
    after = interpreter.advance_history(state, action, [key], state, history)
    assert after["last lamp.shade"][0].tolist() == shades.tolist()
    assert after["memory seen"][0].tolist() == [[1] * 3, [2] * 3, [3] * 3]
    # dark follows the action, which now is known: lamp 0 stays dark at the first step only.
    assert after["memory dark"].tolist() == history["memory dark"].tolist()
    again = interpreter.advance_history(state, action, [key], state, after)
    assert again["memory dark"].tolist() == [[True, False, True], [False, False, True]]


def test_a_trace_restarts_its_history() -> None:
    table = trace(model_of(TIGER), 1, 50, 40)
    names = columns(model_of(TIGER))
    policy = table[:, names.index("policy")].reshape(40, 50)
    assert set(policy[0].tolist()) == {LISTEN}
    assert set(policy.ravel().tolist()) == {LISTEN, OPEN_LEFT, OPEN_RIGHT}
