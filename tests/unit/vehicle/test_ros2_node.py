# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 node of examples/vehicle, with mocks in place of ROS: what it calls, and what it commands."""

import json
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest
from vehicle import ros2_node
from vehicle.ros2_node import SIZES, RosCalls, RosPlanner, Vehicle

from hypgen.codegen.ros2.messages import Messages
from hypgen.dsl.load import load

MODEL = Path(__file__).parents[3] / "examples" / "vehicle" / "vehicle.pomdp"
MODULES = (
    *("rclpy", "rclpy.action", "rclpy.callback_groups", "geometry_msgs", "geometry_msgs.msg", "nav_msgs"),
    *("nav_msgs.msg", "std_msgs", "std_msgs.msg", "vehicle_msgs", "vehicle_msgs.action", "vehicle_msgs.msg"),
    "vehicle_msgs.srv",
)


class Message(SimpleNamespace):
    """A message of any type."""


@pytest.fixture(autouse=True)
def ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in MODULES:
        monkeypatch.setitem(sys.modules, name, MagicMock())
    sys.modules["std_msgs.msg"].Float32 = Message  # type: ignore[attr-defined]


def node(**parameters: Any) -> MagicMock:
    made = MagicMock()
    made.declare_parameter.side_effect = lambda name, default: Message(value=parameters.get(name, default))
    return made


def answers(calls: list[tuple[str, dict[str, Any]]], **changed: Any) -> Any:
    values = [{"value": "exit(1)", "probability": 0.75}, {"value": "stand", "probability": 0.25}]
    belief = [{"variable": f"ped.intent[{i}]", "values": values} for i in range(SIZES["ped.x"])]
    found = {
        "decision": Message(name="decelerate", status=0, trials=1),
        "status": {"code": 0, "text": ""},
        "json": json.dumps(belief),
    } | changed

    def call(name: str, fields: dict[str, Any]) -> dict[str, Any]:
        calls.append((name, fields))
        return found

    return call


def point(x: float, y: float) -> Message:
    return Message(position=Message(x=x, y=y))


def test_a_cycle_takes_topics_and_commands_an_acceleration() -> None:
    calls: list[tuple[str, dict[str, Any]]] = []
    robot = node(period=0.5, exits=[0.0, 5.0, 40.0, 5.0])
    vehicle = Vehicle(robot, answers(calls))
    vehicle.follow(Message(poses=[Message(pose=point(0.25 * k, 0.0)) for k in range(100)]))
    moves = Message(twist=Message(linear=Message(x=1.0)))
    vehicle.move(Message(pose=Message(pose=point(1.0, 0.1)), twist=moves))
    for _ in range(2):
        for k in range(4):
            vehicle.see(Message(poses=[point(6.0 + 0.1 * k, 1.0)]))
        vehicle.cycle()
    published = [call.args[0].data for call in robot.create_publisher.return_value.publish.call_args_list]
    assert published == [0.0, -0.8]
    assert [name for name, _ in calls] == ["reset", "plan", "reset", "observation", "belief", "reset", "plan"]
    first, seen, last = calls[0][1], calls[3][1], calls[5][1]
    assert first["visible_given"] and first["car_exit_x"][:2] == [0.0, 40.0]
    assert first["car_px"][0] == pytest.approx(1.5, abs=0.2)
    assert first["ped_x"][0] == pytest.approx(6.75, abs=0.3)
    assert seen["action"] == 0 and seen["ped_x"][1] == 1000.0
    assert np.array(last["ped_prior"]).reshape(8, 8)[0, 3] == pytest.approx(0.75, abs=0.01)


def test_a_reset_has_all_fields_of_the_generated_service() -> None:
    calls: list[tuple[str, dict[str, Any]]] = []
    vehicle = Vehicle(node(), answers(calls))
    vehicle.follow(Message(poses=[Message(pose=point(0.25 * k, 0.0)) for k in range(100)]))
    vehicle.cycle()
    visible = Messages(load(MODEL).model).visible
    fields = {f.name: int(f.type.partition("[")[2].rstrip("]") or 0) for f in visible}
    fields |= {"episode": 0, "visible_given": 0}
    given = calls[0][1]
    assert set(given) == set(fields)
    assert {n: len(given[n]) for n, size in fields.items() if size} == {n: s for n, s in fields.items() if s}


def test_a_refusal_is_an_error_and_an_odd_update_a_status() -> None:
    planner = RosPlanner(answers([], status={"code": 100, "text": "no"}), SIZES)
    with pytest.raises(RuntimeError, match="no"):
        planner.reset({})
    assert RosPlanner(answers([], status={"code": 21, "text": ""}), SIZES).update("brake", {}) == "21"


def test_calls_wait_for_their_answers() -> None:
    robot = MagicMock()
    call = RosCalls(robot)
    future = MagicMock()
    future.result.return_value = Message(status=Message(code=0, text=""), json="[]")
    future.add_done_callback.side_effect = lambda done: threading.Timer(0.01, done, [future]).start()
    robot.create_client.return_value.call_async.return_value = future
    assert call("belief", {}) == {"status": {"code": 0, "text": ""}, "json": "[]"}
    robot.create_subscription.call_args.args[2](Message(code=21, text=""))
    assert call("observation", {})["status"]["code"] == 21


def test_a_planner_that_does_not_answer_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros2_node, "WAITS", 0.01)
    with pytest.raises(TimeoutError):
        RosCalls(MagicMock())("reset", {})
