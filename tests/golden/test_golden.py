"""Generated projects, byte for byte. A changed golden file is a diff to review, not to wave through."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from support import ir_samples

from hypgen.codegen.generate import generate, generate_library, generate_ros2, generate_verify
from hypgen.dsl import ir
from hypgen.dsl.load import load

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
MODELS = [
    "first_look.pomdp",
    "rock_sample.pomdp",
    "tag.pomdp",
    "tiger.pomdp",
    "tiger_memory.pomdp",
    "two_robot_rock_sample.pomdp",
    "rocks",
    "wanderer",
]

CHECKED = ["first_look.pomdp"]
ROS2 = ["rock_sample.pomdp"]
LIBRARIES = ["first_look.pomdp", "rock_sample.pomdp", "two_robot_rock_sample.pomdp"]


def model(name: str) -> ir.Model:
    if name.endswith(".pomdp"):
        return load((HERE if (HERE / name).exists() else EXAMPLES) / name).model
    found: ir.Model = getattr(ir_samples, name)()
    return found


@pytest.mark.parametrize("name", MODELS)
def test_generated_project(name: str, request: pytest.FixtureRequest) -> None:
    folder = HERE / name.removesuffix(".pomdp")
    files = generate(model(name))
    if request.config.getoption("--accept", default=False):
        shutil.rmtree(folder, ignore_errors=True)
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8")
    golden = {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*")
        if path.is_file()
    }
    assert sorted(files) == sorted(golden)
    for path, text in files.items():
        assert text == golden[path], f"{path}: `pytest tests/golden --accept`, then review the diff"


@pytest.mark.parametrize(
    "name, folder, generated",
    [
        *((name, "libraries", generate_library) for name in LIBRARIES),
        *((name, "checks", generate_verify) for name in CHECKED),
    ],
)
def test_what_else_is_generated(
    name: str, folder: str, generated: Callable[[ir.Model], dict[str, str]], request: pytest.FixtureRequest
) -> None:
    """The model's header and its unit for GPUs are those of its project."""
    place = HERE / folder / name.removesuffix(".pomdp")
    project, files = generate(model(name)), generated(model(name))
    own = {path: text for path, text in files.items() if project.get(path) != text}
    if request.config.getoption("--accept", default=False):
        shutil.rmtree(place, ignore_errors=True)
        for path, text in own.items():
            (place / path).parent.mkdir(parents=True, exist_ok=True)
            (place / path).write_text(text, encoding="utf-8")
    golden = {
        path.relative_to(place).as_posix(): path.read_text(encoding="utf-8")
        for path in place.rglob("*")
        if path.is_file()
    }
    assert own == golden, "`pytest tests/golden --accept`, then review the diff"


@pytest.mark.parametrize("name", ROS2)
def test_generated_ros2_packages(name: str, request: pytest.FixtureRequest) -> None:
    """The solver in the planner's package is the model's project."""
    folder = HERE / "ros2" / name.removesuffix(".pomdp")
    solver, files = generate_ros2(model(name))
    own = {path: text for path, text in files.items() if not path.startswith(f"{solver}/")}
    assert generate(model(name)) == {
        path.removeprefix(f"{solver}/"): text for path, text in files.items() if path not in own
    }
    if request.config.getoption("--accept", default=False):
        shutil.rmtree(folder, ignore_errors=True)
        for path, text in own.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8")
    golden = {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*")
        if path.is_file()
    }
    assert own == golden, "`pytest tests/golden --accept`, then review the diff"


def test_an_instance_differs_from_its_model_in_numbers_alone() -> None:
    headers = [
        generate(model(f"{name}.pomdp"))["src/rock_sample.hpp"] for name in ("rock_sample", "rs_11_11")
    ]
    banner, number = re.compile(r"SHA-256 \w+"), re.compile(r"\d+(\.\d+f?)?")
    first, second = (number.sub("0", banner.sub("", header)) for header in headers)
    assert first == second


def test_generating_twice_gives_the_same_bytes() -> None:
    assert generate(model("tiger.pomdp")) == generate(model("tiger.pomdp"))
