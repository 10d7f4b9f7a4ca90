# SPDX-License-Identifier: Apache-2.0
"""An array's update visits the only entry that it can change, and all entries where it may change several."""

from __future__ import annotations

import pytest

from hypgen.codegen.generate import generate
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.ast import ModelFile
from hypgen.dsl.syntax.parse import parse

MODEL = """model Entries
discount 0.9
type Row = 0 .. 9
type Column = 0 .. 4
action act: bool
element e {{
  hidden row: Row  hidden column: Column
  hidden food: bool[Row, Column]
  init row = 3  init column = 1
  init food = [r in Row, c in Column: true]
  row' = wrap(row + 1)  column' = wrap(column + 1)
  food' = [r in Row, c in Column: {value}]
}}
reward step = if e.food[2, 3] then 1 else 0
observe seen: bool = e.food[1, 2]
policy default = false
bound upper = 10
bound tail = 0
"""


def update(value: str) -> str:
    """Return the C++ of the update of ``food``."""
    source = Source("entries.pomdp", MODEL.format(value=value))
    file = parse(source)
    assert isinstance(file, ModelFile)
    text = generate(lower(file, {}, source))["src/entries.hpp"]
    return text.split("void update_e_stage_1(")[1].split("\n  }\n")[0].partition("{\n")[2]


@pytest.mark.parametrize(
    ("value", "body"),
    [
        ("food[r, c] and not (r == row' and c == column')", ["next.set_e_food(r, c, false);"]),
        ("food[r, c] or (row' == r and c == column')", ["next.set_e_food(r, c, true);"]),
        (
            "if r == row' and c == 2 then not food[r, c] else food[r, c]",
            ["next.set_e_food(r, c, !state.e_food(r, c));"],
        ),
    ],
)
def test_one_entry_is_visited(value: str, body: list[str]) -> None:
    assert "for (" not in update(value)
    assert [line.strip() for line in update(value).splitlines() if "set_" in line] == body


@pytest.mark.parametrize(
    ("value", "loops"),
    [
        ("food[r, c] and not (r == row')", 1),
        ("food[r, c] and not (r == row' or c == column')", 2),
        ("food[r, c] and r == row' and c == column'", 2),
        ("food[r, c] and not (r == row' + 1 and c == column')", 1),  # may be no row
        # Only where the condition holds is row - 4 a row.
        ("if row > 3 then food[r, c] and not (r == row - 4 and c == column') else food[r, c]", 1),
    ],
)
def test_what_may_change_is_visited(value: str, loops: int) -> None:
    assert update(value).count("for (") == loops
