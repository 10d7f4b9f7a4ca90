# SPDX-License-Identifier: Apache-2.0
"""Records of floats become scalars: what they are called, and what a model of them computes."""

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse, parse_expression

TEXT = """
model Walk
record Vec { x, y: float<m> }
record Pose { at: Vec  heading: float  moving: bool }
type Place = Vec
type Spot = 0 .. 1
enum Act { wait, east, north }
discount 0.9
action act: Act
const origin: Place = Vec(0.5, -0.25)
param goals: Vec[Spot] = [Vec(3, 1), Vec(0, 4)]
param start: Vec
fn plus(a: Vec, b: Vec): Vec = let c = a in Vec(c.x + b.x, c.y + b.y)
element robot {
  hidden pose: Pose
  init pose = Pose(plus(start, origin), 0, true)
  let aim = goals[1]
  pose' = match act {
    wait  => pose
    east  => Pose(plus(pose.at, Vec(1, 0)), pose.heading, pose.moving)
    north => if pose.moving then Pose(Vec(pose.at.x, aim.y), 1, false) else pose
  }
}
reward earned = value(robot.pose.at.x') + value(at(goals, index(act), Vec(9, 9)).y)
policy default {
  let far = plus(goals[0], start)
  choose = if far.x > 1 then east else wait
}
bound upper = 100
bound tail = 0
"""


def model(**settings: str) -> ir.Model:
    source = Source("walk.pomdp", TEXT)
    overrides = {name: parse_expression(Source(name, text)) for name, text in settings.items()}
    return lower(parse(source), overrides, source)


def test_leaves_are_named_by_their_paths() -> None:
    found = model(start="Vec(1, 2)")
    assert [v.name for v in found.variables] == [
        "robot.pose.at.x",
        "robot.pose.at.y",
        "robot.pose.heading",
        "robot.pose.moving",
    ]
    assert [p.name for p in found.params] == ["goals.x", "goals.y", "start.x", "start.y"]
    assert [f.name for f in found.functions] == ["plus.x", "plus.y"]
    assert [x.name for x in found.lets] == ["robot.aim.x", "robot.aim.y"]
    assert found.policy is not None
    assert [x.name for x in found.policy.lets] == ["policy.far.x", "policy.far.y"]
    assert not found.records


def test_settings_reach_each_leaf() -> None:
    found = model(start="plus(Vec(1, 2), origin)", goals="[s in Spot: Vec(s, 7)]")
    assert {p.name: p.default for p in found.params} == {
        "goals.x": (0.0, 1.0),
        "goals.y": (7.0, 7.0),
        "start.x": (1.5,),
        "start.y": (1.75,),
    }


def test_a_step_writes_every_leaf() -> None:
    interpreter = Interpreter(model(start="Vec(1, 2)"), lanes=3)
    draws = PhiloxDraws(derive(1, Stream.TEST, 0), np.arange(3), 0)
    state = interpreter.init_hidden(interpreter.init_visible(draws), draws)
    step = interpreter.step(state, np.array([0, 1, 2]), draws)
    after = {name.removeprefix("robot.pose."): list(values) for name, values in step.after.items()}
    assert after == {
        "at.x": [1.5, 2.5, 1.5],
        "at.y": [1.75, 1.75, 4.0],
        "heading": [0.0, 0.0, 1.0],
        "moving": [True, True, False],
    }
    assert [r / 2**24 for r in step.reward] == [1.5 + 1, 2.5 + 4, 1.5 + 9]
