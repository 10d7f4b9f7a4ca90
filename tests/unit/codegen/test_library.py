# SPDX-License-Identifier: Apache-2.0
"""What a library says of the values that its callers give and get."""

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from hypgen.codegen.generate import generate, generate_library
from hypgen.codegen.layout.naming import file_stem
from hypgen.codegen.model.value_fields import drawn_at_start
from hypgen.dsl.load import load
from hypgen.runtime.builder.tools import find_compiler

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


CODES = """model {name}
enum Turn {{ straight, left(1 .. 3), right(-2 .. 0) }}
record Cell {{ x: -1 .. 1, y: 2 .. 3 }}
record Pose {{ turn: Turn, cell: Cell, ok: bool }}
discount 0.9
{action}
element robot {{ hidden d: bool  init d = true  d' = d }}
reward r = if robot.d then 1 else 0
"""
CODES_MAIN = """#include "team.h"
#include "shift.h"

int main(void) {
  int32_t code, action;
  for (code = 0; code < 7 * 6 * 2; ++code) {
    const team_pose pose = team_pose_of(code);
    const team_cell cell = team_cell_of(pose.cell);
    if (team_pose_code(pose) != code || team_cell_code(cell) != pose.cell) return 1;
    if (cell.x < -1 || cell.x > 1 || cell.y < 2 || cell.y > 3 || pose.ok != code % 2) return 2;
    if (team_turn_is_left(pose.turn) &&
        team_turn_left(team_turn_left_argument(pose.turn)) != pose.turn)
      return 3;
    if (team_turn_is_right(pose.turn) &&
        team_turn_right(team_turn_right_argument(pose.turn)) != pose.turn)
      return 4;
  }
  for (action = 0; action < TEAM_ACTIONS; ++action) {
    int32_t parts[2];
    team_action_parts(action, parts);
    if (team_action(parts) != action || parts[0] != action / 84) return 5;
  }
  {
    const team_cell wrong = {2, 2};
    const int32_t parts[2] = {0, 84};
    if (team_cell_code(wrong) != -1 || team_turn_left(4) != -1 || team_action(parts) != -1) return 6;
  }
  for (action = 0; action < SHIFT_ACTIONS; ++action)
    if (shift_action(shift_action_value(action)) != action) return 7;
  return shift_action(-2) != 0 || shift_action(4) != -1 || TEAM_TURN_RIGHT != team_turn_right(-2);
}
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
    header = files["include/start.h"]
    for line in (
        "START_ACTIONS = 4,",
        "START_VISIBLE = 5,",
        "START_AT_ROBOT_HEAT = 4,",
        "START_ACT_GO = 1, /* the first of 3, of argument 2 */",
        "START_SEES_ROBOT_B = 0,",
    ):
        assert f"  {line}\n" in header


@pytest.mark.parametrize(
    "line",
    [
        "static inline int32_t start_act_go(int32_t argument) {\n"
        "  return argument >= 2 && argument <= 4 ? argument - 1 : -1;\n}\n",
        "static inline int start_act_is_go(int32_t code) {\n  return code >= 1 && code < 4;\n}\n",
        "static inline int32_t start_act_go_argument(int32_t code) {\n  return code + 1;\n}\n",
        "typedef struct start_place {\n  int32_t x; /* 0 .. 1 */\n  int32_t y; /* 0 .. 2 */\n}",
    ],
)
def test_the_header_has_arguments_and_records(files: dict[str, str], line: str) -> None:
    assert line in files["include/start.h"]
    assert "start_action(" not in files["include/start.h"], "an action's number is its code"


@pytest.mark.cxx
@pytest.mark.parametrize(("language", "standard"), [("c", "c11"), ("c++", "c++17")])
def test_codes_go_there_and_back(language: str, standard: str, tmp_path: Path) -> None:
    """Over all values of a record in a record, of a variant's argument, and of joint and shifted actions."""
    for name, action in (("Team", "action act: Pose[0 .. 1]"), ("Shift", "action act: -2 .. 3")):
        (tmp_path / f"{name}.pomdp").write_text(CODES.format(name=name, action=action))
        model = load(tmp_path / f"{name}.pomdp").model
        (tmp_path / f"{name.lower()}.h").write_text(generate_library(model)[f"include/{name.lower()}.h"])
    main = tmp_path / "main.c"
    main.write_text(CODES_MAIN)
    flags = [f"-std={standard}", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"]
    where = [f"-I{tmp_path}", f"-I{ROOT / 'runtime' / 'include'}"]
    compiler = str(find_compiler().path)
    build = [compiler, "-x", language, *flags, *where, str(main), "-o", str(tmp_path / "main")]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert subprocess.run([tmp_path / "main"]).returncode == 0


@pytest.mark.parametrize("example", sorted((ROOT / "examples").rglob("*.pomdp")), ids=lambda path: path.stem)
def test_every_example_has_a_header(example: Path) -> None:
    model = load(example).model
    assert f"_ACTIONS = {model.action.count}," in generate_library(model)[f"include/{file_stem(model)}.h"]


def test_another_name_changes_names_alone() -> None:
    model = load(ROOT / "examples" / "rock_sample.pomdp").model
    other = generate(replace(model, name="LargeRocks"))["src/large_rocks.hpp"]
    assert other.replace("LargeRocks", "RockSample") == generate(model)["src/rock_sample.hpp"]


def test_the_models_own_sources_are_those_of_the_solver(files: dict[str, str]) -> None:
    sources = {path for path in files if path.startswith("src/")}
    assert sources == {"src/start.hpp", "src/library.cpp", "src/shared.cpp", "src/device.cu"}
