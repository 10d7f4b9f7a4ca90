# SPDX-License-Identifier: Apache-2.0
"""Arrays that strings of glyphs write."""

import re

import pytest

from hypgen.dsl import ir
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse, parse_expression

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


@pytest.mark.parametrize(
    ("declared", "values"),
    [
        ('float[Row, Col] = ["0 0.5 -1", "1e3 2 3"]', (0.0, 0.5, -1.0, 1000.0, 2.0, 3.0)),
        ('float[Row, Col] = ["0 0.5", "-1 1e3 2", "3"]', (0.0, 0.5, -1.0, 1000.0, 2.0, 3.0)),
        ('prob[Row] = " 0.5  1 "', (0.5, 1.0)),
        ('Col[Row] = "-1 1"', (-1, 1)),
        ('bool[Row] = "true false"', (True, False)),
        ('Act[Row] = "go go"', (0, 0)),
    ],
)
def test_strings_list_entries_in_order(declared: str, values: tuple[float, ...]) -> None:
    [table] = load(f"const table: {declared}").tables
    assert table.values == values


@pytest.mark.parametrize(
    ("declared", "told"),
    [
        ('float[Row] = "1 nan"', "'nan' is no value of 'float'"),
        ('Col[Row] = "0 2"', "'2' is no value of '-1 .. 1'"),
        ('prob[Row] = "0 1.5"', "'1.5' is no value of 'prob'"),
        ('float[Row] = "1 2 3"', "takes 2 entries, but 3 are listed"),
        ('float[Row, Col] = ["1 2 3", [1, 2, 3]]', "strings stand beside other entries"),
    ],
)
def test_words_that_do_not_fit_are_told(declared: str, told: str) -> None:
    with pytest.raises(ModelError, match=re.escape(told)):
        load(f"const table: {declared}")
