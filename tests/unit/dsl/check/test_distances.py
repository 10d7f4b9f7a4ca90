# SPDX-License-Identifier: Apache-2.0
"""Tables of shortest paths, and constant tables computed by closures."""

import pytest

from hypgen.dsl import ir
from hypgen.dsl.check.constants.closures import Closures, Irregular
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse

TEXT = """model M
const n: int = 4
type Cell = 1 .. n
record Pos { row: 0 .. 2  col: 0 .. 2 }
enum Kind { plain, deep(bool), last }
const wall: bool[Pos] = [p in Pos: p == Pos(0, 1) or p == Pos(1, 1)]
fn linked(a: Pos, b: Pos): bool = not wall[a] and not wall[b] and abs(a.row - b.row) + abs(a.col - b.col) == 1
enum Act { go }
action act: Act
discount 0.9
"""


def tables(text: str) -> dict[str, tuple[bool | int | float, ...]]:
    source = Source("m.pomdp", TEXT + text)
    file = parse(source)
    assert isinstance(file, ast.ModelFile)
    model = lower(file, {}, source)
    params = {p.name: p.default for p in model.params if p.default is not None}
    return params | {t.name: t.values for t in model.tables}


def test_links_cost_one_by_default() -> None:
    found = tables("const d: int[Cell, Cell] = distance(a in Cell, b in Cell where abs(a - b) == 1)")
    assert found["d"] == tuple(abs(a - b) for a in range(4) for b in range(4))


def test_paths_go_around_walls_and_what_is_not_reached_is_far() -> None:
    found = tables("param d: int[Pos, Pos] = distance(a in Pos, b in Pos where linked(a, b) else n * 100)")
    d = found["d"]
    assert [d[0 * 9 + p] for p in range(9)] == [0, 400, 6, 1, 400, 5, 2, 3, 4]
    assert d[1 * 9 + 1] == 0 and d[1 * 9 + 0] == 400


def test_costs_may_differ_by_direction() -> None:
    text = (
        "const d: float[Cell, Cell] = "
        "distance(a in Cell, b in Cell where a != b: if a < b then 0.75 * (b - a) else 5)"
    )
    d = tables(text)["d"]
    assert d[0 * 4 + 3] == 2.25 and d[3 * 4 + 0] == 5 and d[3 * 4 + 2] == 5
    text = "const d: float[Cell, Cell] = distance(a in Cell, b in Cell where b == a % n + 1: 0.1 * a)"
    assert tables(text)["d"][0 * 4 + 2] == 0.30000001192092896


def test_costs_need_only_exist_where_values_are_linked() -> None:
    text = (
        "const up: float[0 .. 3] = [0.5, 1.5, 2.5, 3.5]\n"
        "fn next(a: Cell, b: Cell): bool = b == a + 1\n"
        "const d: float[Cell, Cell] = distance(a in Cell, b in Cell where next(a, b): up[a % n] else 9)"
    )
    assert tables(text)["d"][:4] == (0, 1.5, 4, 7.5)


CONSTANT = [
    "[c in Cell: c * c - 7 // c + c % 3]",
    "[c in Cell: if c > 1 then c - 1 else min(c, 2)]",
    "[c in Cell: sum(d in Cell where d < c: d * 2) + count(d in Cell where d > c)]",
    "[c in Cell: max(d in Cell where d < c: 10 - d else -3) + argmin(d in Cell: abs(d - c))]",
    "[c in Cell: let k = c + 1 in k * k]",
    "[c in Cell: floor(sqrt(c) * 100.0 - exp(-c / 3) + log(c) * hypot(c, 2) ** 1.5) + sign(2 - c)]",
    "[c in Cell: ceil(-c / 3) + round(c * 0.5) + clamp(c, 2, 3) + square(c)]",
    "[c in Cell: index(Pos(1, c - 1 - clamp(c - 3, 0, 1))) + Pos(1, 2).row * 7]",
    "[c in Cell: match kind(c) { plain => 5  deep(b) => (if b then 6 else 7)  last => 8 }]",
    "[c in Cell: if any(d in Cell: d == c + 1) and not all(d in Cell: d > c) then 1 else base[c]]",
]


@pytest.mark.parametrize("entries", CONSTANT)
def test_closures_agree_with_constant_folding(entries: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (
        "const base: int[Cell] = [3, 1, 4, 1]\n"
        "fn square(c: Cell): int = c * c\n"
        "fn kind(c: Cell): Kind = if c == 1 then plain else if c == 4 then last else deep(c == 2)\n"
        f"const t: int[Cell] = {entries}\n"
    )
    fast = tables(text)["t"]
    used: list[ir.Expr] = []

    def refuse(_: Closures, e: ir.Expr) -> object:
        used.append(e)
        raise Irregular

    monkeypatch.setattr(Closures, "code", refuse)
    assert tables(text)["t"] == fast
    assert used


def test_a_value_that_depends_on_conditions_is_checked_by_itself() -> None:
    found = tables("const t: Cell[Cell] = [c in Cell: if c * c > 10 then c - 1 else c]")
    assert found["t"] == (1, 2, 3, 3)


def test_many_entries_are_computed() -> None:
    found = tables("type Many = 0 .. 299\nconst t: int[Many, Many] = [i in Many, j in Many: i * j % 7]")
    assert found["t"][299 * 300 + 298] == 299 * 298 % 7
