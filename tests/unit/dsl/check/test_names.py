# SPDX-License-Identifier: Apache-2.0
"""Names: one may stand in several spaces; one that is taken gives one message."""

from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.dsl.load import load
from hypgen.dsl.messages.diagnostic import ModelError

HEAD = """model M
type Cell = 0 .. 4
record Pos { row, col: Cell }
enum Act { wait, go(Cell) }
discount 0.9
action act: Act
param p: Cell = 2
"""
ROOM = """element room {
  hidden x: Cell
  init x = 0
  x' = if act == wait then x else clamp(x + 1)
}
reward r = if room.x' == p then 1 else 0
"""


def told(text: str, folder: Path) -> list[str]:
    """Return the codes and messages of a model's mistakes."""
    path = folder / "m.pomdp"
    path.write_text(text)
    try:
        load(path)
    except ModelError as error:
        return [f"{d.code} {d.message}" for d in error.diagnostics]
    return []


def test_one_name_in_all_spaces() -> None:
    model = load(ROOT / "tests/differential/models/names.pomdp").model
    assert {v.name for v in model.variables} == {"at.step", "at.cell", "fuel.fuel", "move.filled"}


@pytest.mark.parametrize(
    "more",
    [
        "fn act(c: Cell): Cell = c\nreward s = act(2)",
        "fn x(c: Cell): Cell = c\nreward s = x(room.x)",
        "type p = 0 .. 1\nreward s = sum(i in p: p + i)",
        "element p { visible y: Cell  init y = p  y' = y }\nreward s = p.y + p",
        "element go { visible y: Cell  init y = 1  y' = if act == go(y) then y else 0 }",
        "reward s = sum(go in Cell where act == go(go): go)",
        "reward s = sum(room in Cell: room + room.x)",
        "fn f(room: Pos): Cell = room.row + 0 * room.x\nreward s = f(Pos(1, 2))",
        # Records of floats are taken apart before names are looked up.
        """record Vec { a, b: float }
        element go[i in Cell] { hidden go: Vec  hidden y: Cell  init go = Vec(0, 1)  init y = 0
          go' = go  y' = if go.a > 0 then go[y].y else 1 }
        reward s = clamp(go[1].go.a, 0, 1) + go[2].y'""",
        "record Vec { a: float }\nparam room: Vec = Vec(1)\nreward s = room.x + room.a",
    ],
)
def test_names_that_the_grammar_tells_apart(more: str, tmp_path: Path) -> None:
    assert told(HEAD + ROOM + more + "\n", tmp_path) == []


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("fn wait(c: Cell): Cell = c\nparam wait: Cell = 1\nreward s = wait", "'wait' is already declared"),
        (
            "element e { hidden wait: Cell  init wait = 0  wait' = if act == wait then wait else 0 }",
            "'wait' shadows a variant of 'Act' of that name",
        ),
        (
            "element e { hidden act: Cell  init act = 0  act' = if act == wait then 1 else 0 }",
            "'act' shadows the action of that name",
        ),
        ("param p: bool = true\nreward s = if p then 1 else 0", "'p' is already declared"),
        (
            "fn f(c: Cell): Cell = c\nfn f(b: bool): bool = b\nreward s = if f(true) then f(2) else 0",
            "'f' is already declared",
        ),
        ("fn go(c: Cell): Cell = c\nreward s = go(1)", "'go' is already declared"),
        (
            "record Cell { b: bool }\nelement e { hidden c: Cell  init c = Cell(true)  c' = c }",
            "'Cell' is already declared",
        ),
        (
            "element room { hidden y: bool  init y = true  y' = y }\nreward s = if room.y then 1 else 0",
            "'room' is already declared",
        ),
        (
            "element e { hidden y: Cell  hidden y: bool  init y = 0  init y = true  y' = y  y' = not y }",
            "'y' is already declared",
        ),
        ("enum Turn { left, left }\nparam t: Turn = left", "'left' is already declared"),
        ("param gamma: float = 1\nreward s = gamma", "'gamma' is built in"),
        ("enum Sign { abs(Cell) }\nparam t: Sign = abs(1)", "'abs' is built in"),
    ],
)
def test_a_name_that_is_taken_gives_one_message(more: str, message: str, tmp_path: Path) -> None:
    assert told(HEAD + ROOM + more + "\n", tmp_path) == [f"E0202 {message}"]


def test_a_record_of_floats_whose_name_is_taken_is_told_once(tmp_path: Path) -> None:
    taken = "record Vec { x, y: float }\nfn Vec(c: Cell): float = 1.0\n"
    assert told(HEAD + taken + ROOM + "reward s = Vec(1.0, 2.0).x\n", tmp_path) == [
        "E0202 'Vec' is already declared"
    ]


@pytest.mark.parametrize(
    ("asked", "told"),
    [("x", "last(place.x, first)"), ("tick", "last(ear[i].tick, first)"), ("place", "take one of its parts")],
)
def test_last_of_a_part_of_a_name_is_told_the_whole(asked: str, told: str, tmp_path: Path) -> None:
    text = f"""model M
record Vec {{ x, y: float }}
discount 0.9
action act: bool
observe place: Vec ~ Vec(normal(0, 1), normal(0, 1))
element ear[i in 0 .. 1] {{ observe tick: bool ~ bernoulli(0.5) }}
policy default = last({asked}, 0) == 0
"""
    path = tmp_path / "m.pomdp"
    path.write_text(text)
    with pytest.raises(ModelError) as caught:
        load(path)
    assert any(told in d.remedy for d in caught.value.diagnostics), caught.value.diagnostics


@pytest.mark.parametrize("entry", ["cost[c]", "cost", "1 + cost[0]"])
@pytest.mark.parametrize("use", ["", "bound upper = cost[p]\n"])
def test_an_array_that_is_made_of_itself_is_told(entry: str, use: str, tmp_path: Path) -> None:
    """Entries are checked one by one where they do not all pass at once."""
    circle = f"const cost: int[Cell] = [c in Cell: {entry}]\n"
    assert told(HEAD + circle + ROOM + use, tmp_path) == [
        "E0208 const cost is defined by itself: const cost -> const cost"
    ]
