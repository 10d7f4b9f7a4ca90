# SPDX-License-Identifier: Apache-2.0
"""``hypgen compile --emit ros2``: the node compiles against stubs of ours, and does what ROS asks of it."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.native import build_with_cmake
from support.ros2 import node

from hypgen.api import Solver
from hypgen.dsl.load import load
from hypgen.runtime.builder import tools

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
SUPPORT = ROOT / "tests" / "support" / "ros2"

HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
EXAMPLES = ("crowd_driving", "light_dark", "tiger", "two_robot_rock_sample", "vehicle/vehicle")


def hypgen(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_the_node_compiles(name: str, tmp_path: Path) -> None:
    node.check(load(ROOT / "examples" / f"{name}.pomdp").model, tmp_path)


def test_the_node_of_rock_sample_does_what_ros_asks(tmp_path: Path) -> None:
    model = load(ROOT / "examples" / "rock_sample.pomdp").model
    program, library = node.build(model, SUPPORT / "rocks_main.cpp", tmp_path)
    done = subprocess.run([program], capture_output=True, text=True, timeout=300)
    lines = done.stdout.splitlines()
    checks = [line for line in lines if not line.startswith("decision ")]
    assert [line for line in checks if not line.endswith(": ok")] == [], done.stderr
    assert done.returncode == 0 and len(checks) == 12

    # The node decides as any caller of the library does.
    settings = {"mode": "despot", "trials": 60, "scenarios": 100, "particles": 500, "memory": 64, "seed": 3}
    with Solver(library).planner(params={"start_row": 1}, **settings) as planner:
        planner.reset(episode=2)
        for line in (line for line in lines if line.startswith("decision ")):
            found = planner.plan()
            assert line == f"decision {found.action} {found.lower:.17g} {found.upper:.17g}"
            reading = "looks_bad" if found.name.startswith("check") else "nothing"
            planner.update(found.action, {"reading": reading})


@pytest.mark.slow
def test_a_node_takes_values_of_every_kind(tmp_path: Path) -> None:
    model = load(SUPPORT / "odd_names.pomdp").model
    program, _ = node.build(model, SUPPORT / "odd_names_main.cpp", tmp_path)
    done = subprocess.run([program], capture_output=True, text=True, timeout=300)
    checks = done.stdout.splitlines()
    assert [line for line in checks if not line.endswith(": ok")] == [], done.stderr
    assert done.returncode == 0 and len(checks) == 3


@pytest.mark.slow
def test_both_packages_are_built_by_cmake(tmp_path: Path) -> None:
    """With packages of CMake of our own in place of those of ROS, and the runtime that is built already."""
    model, packages = ROOT / "examples" / "tiger.pomdp", tmp_path / "packages"
    for output in (["--library", "-o", str(tmp_path / "library")], ["--emit", "ros2", "-o", str(packages)]):
        done = hypgen("compile", str(model), "--target", "cpu", *output)
        assert done.returncode == 0, done.stderr
    node.install_ros(load(model).model, tmp_path / "ros")
    installed = tmp_path / "installed"
    settings = [
        f"-DCMAKE_PREFIX_PATH={tmp_path / 'ros'};{tmp_path / 'library'}",
        f"-DCMAKE_INSTALL_PREFIX={installed}",
        "-DHYPGEN_FIND_RUNTIME=ON",
    ]
    for part in ("msgs", "planner"):
        build = build_with_cmake(packages / f"tiger_{part}", tmp_path / part, *settings)
    subprocess.run([str(tools.find_cmake().path), "--install", str(build)], check=True, capture_output=True)
    names = {path.relative_to(installed).as_posix() for path in installed.rglob("*") if path.is_file()}
    assert names == {
        "lib/libtiger.so",
        "lib/tiger_planner/planner_node",
        "share/tiger_planner/config/planner.yaml",
        "share/tiger_planner/launch/tiger_planner.launch.py",
    }
    # Our stub of rclcpp does not spin, so the node ends at once.
    assert subprocess.run([installed / "lib" / "tiger_planner" / "planner_node"]).returncode == 0
