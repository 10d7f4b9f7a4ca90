"""Arrays that strings of glyphs write."""

import pytest

from hypgen.dsl import ast, ir
from hypgen.dsl.lower import lower
from hypgen.dsl.parser import parse, parse_expression
from hypgen.dsl.source import Source

TEXT = """model M
type Row = 0 .. 1
type Col = -1 .. 1
record Pos { row: Row  col: Col }
record Spot { floor: bool  pos: Pos }
enum Cell { floor ".", wall "#", door(bool), lift "↕" }
enum Act { go }
action act: Act
discount 0.9
"""


def load(text: str, **settings: str) -> ir.Model:
    source = Source("m.pomdp", TEXT + text)
    file = parse(source)
    assert isinstance(file, ast.ModelFile)
    overrides = {n: parse_expression(Source("--set", v)) for n, v in settings.items()}
    return lower(file, overrides, source)


@pytest.mark.parametrize(
    ("indices", "literal"),
    [
        ("Row, Col", '["..#", "#↕."]'),
        ("Pos", '["..#", "#↕."]'),
        ("Pos", '"..##↕."'),
        ("0 .. 5", '"..##↕."'),
        ("Row, Col", '["..#", [wall, lift, floor]]'),
        ("Row, Col", "[[floor, floor, wall], [wall, lift, floor]]"),
        ("Row, Col", "named"),
    ],
)
def test_a_grid_is_its_entries_row_major(indices: str, literal: str) -> None:
    named = 'const named: Cell[Row, Col] = ["..#", "#↕."]\n'
    (table,) = [t for t in load(named + f"const map: Cell[{indices}] = {literal}").tables if t.name == "map"]
    assert table.values == (0, 0, 1, 1, 4, 0)


def test_records_of_records_spread_to_all_their_fields() -> None:
    (table,) = load('const map: Cell[Spot] = [["...", "###"], [".#.", "#.#"]]').tables
    assert table.values == (0, 0, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1)


def test_params_and_settings_take_grids() -> None:
    model = load('param map: Cell[Pos] = ["...", "..."]', map='["##.", ".##"]')
    assert model.params[0].default == (1, 1, 0, 0, 1, 1)
