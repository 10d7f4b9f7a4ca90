# SPDX-License-Identifier: Apache-2.0
"""The bridge in ROS 2: between a tracker's topics and the generated planner node.

`hypgen compile examples/vehicle/vehicle.pomdp --emit ros2 -o SRC/vehicle` writes the planner's packages, and
vehicle.launch.py starts both nodes.
"""

from __future__ import annotations

import json
import queue
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vehicle.bridge import Bridge, Situation
from vehicle.hybrid_a_star import Path, path_of
from vehicle.policies import PULLS
from vehicle.sensor import Scan

SIZES = {"ped.x": 8, "car.px": 25, "car.exit_x": 6}  # lengths of the model's variables
WAITS = 2.0  # s for an answer

# Calls of the planner node: a name and the fields of a request or a goal; the fields of the answer.
Call = Callable[[str, dict[str, Any]], Mapping[str, Any]]


class Field:
    """The name and the dimensions of a variable that the planner shows."""

    def __init__(self, name: str, dims: list[int]) -> None:
        self.name, self.dims = name, dims


class RosPlanner:
    """What the bridge asks of a planner, by the services, the topic and the action of the generated node.

    ``sizes`` has the lengths of ``ped.x``, ``car.px`` and ``car.exit_x`` in the model.
    """

    def __init__(self, call: Call, sizes: Mapping[str, int]) -> None:
        self._call = call
        self.visible_fields = [Field(name, [size]) for name, size in sizes.items()]
        self._visible: dict[str, Any] = {
            "car.px": [float(k) for k in range(sizes["car.px"])],
            **{name: [0.0] * sizes["car.px"] for name in ("car.py", "car.limit")},
            "car.reach": 24.0,
            "car.begun": False,
            "car.s": 0.0,
            "car.v": 0.0,
            "car.x": 0.0,
            "car.y": 0.0,
            "car.ux": 1.0,
            "car.uy": 0.0,
        }

    def reset(self, visible: Mapping[str, Any], *, episode: int = 0) -> str:
        """Begin an episode; what is left out stays as it was in the reset before."""
        self._visible |= visible
        fields = {_ros(name): _flat(value) for name, value in self._visible.items()}
        return _status(self._call("reset", {"episode": episode, "visible_given": True, **fields}))

    def update(self, action: str, seen: Mapping[str, Any]) -> str:
        """Take in what was seen after an action."""
        fields = {_ros(name): value for name, value in seen.items()}
        return _status(self._call("observation", {"action": list(PULLS).index(action), **fields}))

    def plan(self, seconds: float = 0.0, *, deadline: float = 0.0) -> Any:
        """Decide until a time of ``time.monotonic``."""
        return self._call("plan", {"seconds": max(seconds or deadline - time.monotonic(), 0.001)})["decision"]

    @property
    def belief(self) -> dict[str, dict[str, float]]:
        """The probabilities of each value of each hidden variable."""
        found = json.loads(self._call("belief", {})["json"])
        return {one["variable"]: {v["value"]: v["probability"] for v in one["values"]} for one in found}


def _ros(name: str) -> str:
    return name.replace(".", "_")


def _flat(value: Any) -> Any:
    if isinstance(value, list) and value and isinstance(value[0], list):
        return [float(v) for row in value for v in row]
    return value


def _status(answer: Mapping[str, Any]) -> str:
    code = answer["status"]["code"]
    if code >= 100:
        raise RuntimeError(answer["status"]["text"])
    return "ok" if code == 0 else str(code)


class RosCalls:
    """Calls of the planner node from a node of rclpy, each of which waits for its answer.

    The node needs an executor of several threads: one waits here while another takes the answer.
    """

    def __init__(self, node: Any, planner: str = "vehicle_planner") -> None:
        from rclpy.action import ActionClient
        from vehicle_msgs.action import Plan
        from vehicle_msgs.msg import Observation, Status
        from vehicle_msgs.srv import Belief, Reset

        self._types = {"reset": Reset, "belief": Belief, "plan": Plan, "observation": Observation}
        self._services = {
            name: node.create_client(self._types[name], f"/{planner}/{name}") for name in ("reset", "belief")
        }
        self._plan = ActionClient(node, Plan, f"/{planner}/plan")
        self._observation = node.create_publisher(Observation, f"/{planner}/observation", 10)
        self._statuses: queue.Queue[Any] = queue.Queue()
        node.create_subscription(Status, f"/{planner}/belief_status", self._statuses.put, 10)

    def __call__(self, name: str, fields: dict[str, Any]) -> Mapping[str, Any]:
        """Make a call; return its answer's fields."""
        kind = self._types[name]
        if name == "observation":
            self._observation.publish(kind(**fields))
            return {"status": _fields(self._statuses.get(timeout=WAITS))}
        if name == "plan":
            goal = _wait(self._plan.send_goal_async(kind.Goal(**fields)))
            return {"decision": _wait(goal.get_result_async()).result.decision}
        answer = _wait(self._services[name].call_async(kind.Request(**fields)))
        return {"status": _fields(answer.status), "json": getattr(answer, "json", "")}


def _fields(status: Any) -> dict[str, Any]:
    return {"code": status.code, "text": status.text}


def _wait(future: Any) -> Any:
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    if not done.wait(WAITS):
        raise TimeoutError("the planner node does not answer")
    return future.result()


class Vehicle:
    """The bridge as a node: topics of a tracker and a path planner in, an acceleration out.

    Detections are a ``PoseArray``, the way a ``Path``, the car's place and speed an ``Odometry``. Exits are a
    parameter: x and y of each, one after the other.
    """

    def __init__(self, node: Any, call: Call | None = None) -> None:
        from geometry_msgs.msg import PoseArray
        from nav_msgs.msg import Odometry
        from nav_msgs.msg import Path as Way
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
        from std_msgs.msg import Float32

        self._message = Float32
        self.period = node.declare_parameter("period", 0.3333).value
        exits = np.array(node.declare_parameter("exits", [0.0, 0.0]).value).reshape(-1, 2)
        planner: Any = RosPlanner(call or RosCalls(node), SIZES)
        self.bridge = Bridge(planner, exits, period=self.period)
        self.tracks = self.bridge.tracks()
        self._path: Path | None = None
        self._s = self._pull = self._speed = 0.0
        self._labels = 0
        node.create_subscription(PoseArray, "detections", self.see, 10)
        node.create_subscription(Odometry, "odometry", self.move, 10)
        node.create_subscription(Way, "path", self.follow, 1)
        self._out = node.create_publisher(Float32, "acceleration", 1)
        apart = MutuallyExclusiveCallbackGroup()  # a cycle waits for answers that other callbacks take
        node.create_timer(self.period, self.cycle, callback_group=apart)

    def see(self, poses: Any) -> None:
        """Take a scan; a lidar of ten hertz is expected, and detections without labels get new ones."""
        at = np.array([[p.position.x, p.position.y] for p in poses.poses]).reshape(-1, 2)
        labels = np.arange(self._labels, self._labels + len(at))
        self._labels += len(at)
        self.tracks.step(Scan(at, labels), 0.1)

    def move(self, odometry: Any) -> None:
        """Take where the car is."""
        at = odometry.pose.pose.position
        self._speed = odometry.twist.twist.linear.x
        if self._path is not None:
            self._s = self._path.project(at.x, at.y, self._s)

    def follow(self, way: Any) -> None:
        """Take another path, whose points are SPACING apart."""
        points = np.array([[p.pose.position.x, p.pose.position.y] for p in way.poses])
        self._path, self._s = path_of(points), 0.0

    def cycle(self) -> None:
        """Command what was decided in the last period, and decide for the next."""
        self._out.publish(self._message(data=self._pull))
        if self._path is None:
            return
        speed = max(0.0, self._speed + self._pull * self.period)
        s = self._s + 0.5 * (self._speed + speed) * self.period
        situation = Situation(self._path, s, speed, self.tracks, self.period)
        end = time.monotonic() + 0.9 * self.period
        self._pull = PULLS[self.bridge.decide(situation, end).name]


def main() -> None:
    """Run the node."""
    import rclpy
    from rclpy.executors import MultiThreadedExecutor

    rclpy.init()
    node = rclpy.create_node("vehicle_bridge")
    vehicle = Vehicle(node)
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    node.get_logger().info(f"a decision each {vehicle.period} s")
    executor.spin()


if __name__ == "__main__":
    main()
