# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 packages of a model as text: names, messages, and what their files say of each other."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock
from xml.etree import ElementTree

import pytest
from support.ros2 import rosidl

from hypgen.codegen.generate import generate_ros2
from hypgen.codegen.ros2.packages import STATUSES
from hypgen.codegen.ros2.parameters import SETTINGS, value_name
from hypgen.codegen.ros2.ros_names import RosScope, header, package_stem
from hypgen.dsl.load import load
from hypgen.dsl.types import BOOL, Enum, Int, Record, Variant

ROOT = Path(__file__).parent.parent.parent.parent
EXAMPLES = sorted((ROOT / "examples").rglob("*.pomdp"))
ODD = ROOT / "tests" / "support" / "ros2" / "odd_names.pomdp"
# Modules of ROS that the launch file imports.
LAUNCH = """
    launch launch.actions launch.conditions launch.event_handlers launch.events launch.substitutions
    launch_ros launch_ros.actions launch_ros.event_handlers launch_ros.events launch_ros.events.lifecycle
    lifecycle_msgs lifecycle_msgs.msg
"""


@pytest.fixture(scope="module")
def odd() -> dict[str, str]:
    return generate_ros2(load(ODD).model)[1]


@pytest.mark.parametrize(
    ("name", "field", "constant"),
    [
        ("rover.x", "rover_x", "ROVER_X"),
        ("looksGood", "looks_good", "LOOKS_GOOD"),
        ("_up__2_", "up_2", "UP_2"),
        ("2d", "value_2d", "VALUE_2D"),
        ("__", "value", "VALUE"),
        ("class", "class_value", "CLASS"),
        ("from", "from_value", "FROM"),
        ("null", "null", "NULL_VALUE"),
    ],
)
def test_a_name_becomes_one_that_ros_takes(name: str, field: str, constant: str) -> None:
    assert RosScope().field(name) == field and rosidl.FIELD.fullmatch(field)
    assert RosScope().constant(name) == constant and rosidl.CONSTANT.fullmatch(constant)


def test_names_that_become_the_same_get_numbers() -> None:
    scope = RosScope()
    assert [scope.field(n) for n in ("a_b", "a__b", "aB", "a_b_2")] == ["a_b", "a_b_2", "a_b_3", "a_b_2_2"]
    scope = RosScope({"status"})
    found = [scope.message(n) for n in ("Reading", "reading", "RS2Map", "Rs2Map", "_2d", "__", "Status")]
    assert found == ["Reading", "Reading2", "RS2Map", "Rs2Map2", "Type2d", "Type", "Status2"]


@pytest.mark.parametrize("name", ["Reading", "RS2Map", "HTTPCode", "A", "AbCd2EF", "X2y"])
def test_a_header_is_named_as_ros_names_it(name: str) -> None:
    assert header(name) == rosidl.header_name(name)


def test_a_package_is_named_after_the_model() -> None:
    assert [package_stem(s) for s in ("rock_sample", "_2odd__names_", "__")] == [
        "rock_sample",
        "model_2odd_names",
        "model",
    ]


@pytest.mark.parametrize("path", [*EXAMPLES, ODD], ids=lambda path: path.stem)
def test_interfaces_follow_the_rules_of_ros(path: Path) -> None:
    """Each file is listed and read, and fields have types that are there."""
    _, files = generate_ros2(load(path).model)
    package = min(files).partition("/")[0]
    made = rosidl.headers(files, package)
    for text in made.values():
        included = set(re.findall(rf"#include <({package}/.*)>", text))
        assert included <= made.keys()


def test_values_of_a_model_become_fields(odd: dict[str, str]) -> None:
    observation, reset = (
        [(f.type, f.length, f.name, f.value) for f in rosidl.read(odd[f"model_2_odd_names_msgs/{name}"])[0]]
        for name in ("msg/Observation.msg", "srv/Reset.srv")
    )
    assert observation == [
        ("int32", None, "LAST_DECISION", "-1"),
        ("int32", None, "action", "-1"),
        ("NullKind", None, "robot_kind", ""),
        ("bool", 8, "action_2", ""),
        ("Pos", None, "robot_class", ""),
        ("float32", None, "robot_far", ""),
    ]
    assert reset[:3] == [
        ("uint64", None, "episode", ""),
        ("bool", None, "visible_given", "true"),
        ("Pos", None, "robot_class", ""),
    ]


def test_statuses_are_those_of_the_header() -> None:
    text = (ROOT / "runtime" / "include" / "hypgen.h").read_text()
    found = re.findall(r"^  HYPGEN_([A-Z_]+) = (\d+)", text, re.MULTILINE)
    assert {name: int(code) for name, code in found} == STATUSES


def test_settings_are_those_of_the_library() -> None:
    text = (ROOT / "runtime" / "src" / "solver" / "settings.hpp").read_text()
    known = re.search(r"kSettings\[\] = \{(.*?)\}", text, re.DOTALL)
    assert known is not None
    # A signature is printed by programs alone.
    assert set(re.findall(r'"(.*?)"', known[1])) - {"signature"} == SETTINGS.keys()


def test_a_value_of_a_param_has_its_name() -> None:
    enum = Enum("Act", (Variant("stay"), Variant("go", Int(2, 4)), Variant("ask", BOOL)))
    record = Record("Both", (("act", enum), ("at", Int(-1, 1))))
    assert [value_name(enum, code) for code in range(6)] == [
        "stay",
        "go(2)",
        "go(3)",
        "go(4)",
        "ask(false)",
        "ask(true)",
    ]
    assert value_name(record, 3 * 3 + 0) == "Both(go(4), -1)"


@pytest.mark.parametrize("part", ["msgs", "planner"])
def test_a_package_says_what_it_needs(odd: dict[str, str], part: str) -> None:
    name = f"model_2_odd_names_{part}"
    package = ElementTree.fromstring(odd[f"{name}/package.xml"])
    assert package.get("format") == "3" and package.findtext("name") == name
    build = odd[f"{name}/CMakeLists.txt"]
    assert f"project({name}" in build and build.rstrip().endswith("ament_package()")
    needed = {e.text for e in package if e.tag in ("depend", "buildtool_depend")}
    assert set(re.findall(r"find_package\((\w+) REQUIRED\)", build)) == needed - {"action_msgs"}


def test_sources_that_are_compiled_are_there(odd: dict[str, str]) -> None:
    build = odd["model_2_odd_names_planner/CMakeLists.txt"]
    sources = re.findall(r"src/\w+\.cpp", build)
    assert sources == [
        path.removeprefix("model_2_odd_names_planner/")
        for path in sorted(odd)
        if re.fullmatch(r"model_2_odd_names_planner/src/\w+\.cpp", path)
    ]


def test_the_launch_file_starts_and_activates_the_node(
    odd: dict[str, str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The modules of ROS are mocks here, so this shows what the file asks of them and no more."""
    modules = {name: MagicMock() for name in LAUNCH.split()}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    name = "model_2_odd_names_planner"
    values: dict[str, Any] = {"__file__": str(tmp_path / "launch" / f"{name}.launch.py")}
    exec(odd[f"{name}/launch/{name}.launch.py"], values)
    values["generate_launch_description"]()
    given = modules["launch_ros.actions"].LifecycleNode.call_args.kwargs
    assert (given["package"], given["executable"], given["name"]) == (name, "planner_node", name)
    argument = modules["launch.actions"].DeclareLaunchArgument
    defaults = {call.args[0]: call.kwargs["default_value"] for call in argument.call_args_list}
    config = str(tmp_path / "config" / "planner.yaml")
    assert defaults == {"namespace": "", "params_file": config, "autostart": "true"}
    transition = modules["lifecycle_msgs.msg"].Transition
    asked = modules["launch_ros.events.lifecycle"].ChangeState.call_args_list
    assert [SimpleNamespace(**call.kwargs).transition_id for call in asked] == [
        transition.TRANSITION_CONFIGURE,
        transition.TRANSITION_ACTIVATE,
    ]


def test_what_is_seen_of_a_continuous_law_is_a_number() -> None:
    model = load(ROOT / "tests" / "differential" / "models" / "continuous_sensors.pomdp").model
    files = generate_ros2(model)[1]
    (message,) = (text for path, text in files.items() if path.endswith("msg/Observation.msg"))
    fields = [line.partition("  #")[0] for line in message.splitlines()]
    assert {"float32 width", "float32 place_x", "float32 place_y", "float32[9] wall_echo"} <= set(fields)
