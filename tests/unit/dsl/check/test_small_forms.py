# SPDX-License-Identifier: Apache-2.0
"""Small forms mean what their long forms mean: both give the same IR."""

from pathlib import Path

import pytest

from hypgen.dsl.ir.walk import shape
from hypgen.dsl.load import load

MODEL = """model M
type Cell = 0 .. 4
record Pos {{ row, col: Cell }}
record Vec {{ x, y: float }}
enum Act {{ wait, go(Pos), look(Cell) }}
discount 0.9
action act: Act
param wall: bool[Pos] = [p in Pos: p.row == p.col]
param cost: float[Pos, Cell] = [p in Pos, c in Cell: 1.0]
element robot {{
  hidden at: Pos
  hidden v: Vec
  init at = Pos(0, 1)
  init v = Vec(0, 1)
  at' {at}
  v' = {v}
}}
reward r = {r}
bound upper = 0
bound tail = 0
"""
KEPT = {"at": "= at", "v": "v", "r": "0"}


def updates(folder: Path, **parts: str) -> list[object]:
    path = folder / "m.pomdp"
    path.write_text(MODEL.format(**KEPT | parts))
    model = load(path).model
    dists = [shape(getattr(a.dist, "value", None)) if a.dist else None for a in model.updates]
    return [*dists, *(shape(r.value) for r in model.rewards)]


@pytest.mark.parametrize(
    ("name", "short", "long"),
    [
        ("r", "if act is go then 1 else 0", "match act { go(p) => 1  else => 0 }"),
        ("at", "= at with { row = 3 }", "= Pos(3, at.col)"),
        ("at", "= at with { col = at.row, row = at.col, }", "= Pos(at.col, at.row)"),
        ("v", "v with { x = v.x + 1 }", "Vec(v.x + 1, v.y)"),
        (
            "v",
            "(if act is go then v else Vec(2, 3)) with { y = 1 }",
            "Vec((if act is go then v else Vec(2, 3)).x, 1)",
        ),
        (
            "r",
            "if any(p in Pos where wall[p]) then 1 else 0",
            "if any(p in Pos where wall[p]: true) then 1 else 0",
        ),
        ("r", "at(cost, robot.at, 1, 0)", "cost[robot.at, 1]"),
        ("r", "at(cost, 1, 2, 3, 0.0)", "cost[Pos(1, 2), 3]"),
        ("r", "let d: Cell = 2 in d + 1", "let d = 2 in d + 1"),
    ],
)
def test_short_and_long_forms(tmp_path: Path, name: str, short: str, long: str) -> None:
    assert updates(tmp_path, **{name: short}) == updates(tmp_path, **{name: long})


def test_an_index_by_fields_beyond_the_map_gives_the_default(tmp_path: Path) -> None:
    """Each number is compared with its field's range, and the index is made of those in range."""
    short = updates(tmp_path, r="if at(wall, robot.at.row + 1, robot.at.col, true) then 1 else 0")
    long = updates(tmp_path, r="if at(wall, Pos(robot.at.row, robot.at.col), true) then 1 else 0")
    assert str(short).count("'le'") > str(long).count("'le'") == 0
