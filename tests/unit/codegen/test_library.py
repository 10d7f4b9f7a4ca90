# SPDX-License-Identifier: Apache-2.0
"""What a library says of the values that its callers give and get."""

from pathlib import Path

import pytest

from hypgen.codegen.generate import generate_library
from hypgen.codegen.model.value_fields import drawn_at_start
from hypgen.dsl.load import load

ROOT = Path(__file__).parent.parent.parent.parent
MODEL = """model Start
type Cell = 0 .. 5
param corner: Cell = 2
enum Act { stay, go(2 .. 4) }
record Place { x: 0 .. 1, y: 0 .. 2 }
discount 0.9
action act: Act
element robot {
  visible a, b, c: 0 .. 5
  visible place: Place
  visible heat: float
  hidden d: bool
  init a = corner
  init b ~ uniform(Cell)
  init c = b
  init place = Place(1, 2)
  init heat = 0.5
  init d ~ bernoulli(0.5)
  a' = a
  b' ~ uniform(Cell)
  c' = c
  place' = place
  heat' = heat
  d' = d
}
reward r = if robot.d then 1 else 0
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    path = tmp_path_factory.mktemp("start") / "start.pomdp"
    path.write_text(MODEL)
    return generate_library(load(path).model)


def test_a_first_value_is_drawn_directly_or_through_others(tmp_path: Path) -> None:
    path = tmp_path / "start.pomdp"
    path.write_text(MODEL)
    assert drawn_at_start(load(path).model) == {"robot.b", "robot.c", "robot.d"}


@pytest.mark.parametrize(
    "field",
    [
        '{"robot.a", {}, hypgen::ValueKind::kInt, 0, 5, {}},',
        '{"robot.c", {}, hypgen::ValueKind::kInt, 0, 5, {}, true},',
        '{"robot.place", {}, hypgen::ValueKind::kNamed, 0, 5, name_of_Place},',
        '{"robot.heat", {}, hypgen::ValueKind::kFloat, '
        "-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), {}},",
    ],
)
def test_fields_have_types_and_ranges(files: dict[str, str], field: str) -> None:
    assert field in files["src/library.cpp"]


def test_the_header_has_codes_and_places(files: dict[str, str]) -> None:
    header = files["package/include/start.h"]
    for line in (
        "START_ACTIONS = 4,",
        "START_VISIBLE = 5,",
        "START_AT_ROBOT_HEAT = 4,",
        "START_ACT_GO = 1, /* the first of 3, of argument 2 */",
        "START_SEES_ROBOT_B = 0,",
    ):
        assert f"  {line}\n" in header


def test_the_models_own_sources_are_those_of_the_solver(files: dict[str, str]) -> None:
    sources = {path for path in files if path.startswith("src/")}
    assert sources == {"src/start.hpp", "src/library.cpp", "src/device.cu"}
