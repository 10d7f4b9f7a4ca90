# SPDX-License-Identifier: Apache-2.0
"""What conditions show: idioms that must check, each in a function of its own."""

import pytest

from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

FRAME = """
model Idioms
const n: int = 8
type Col = 0 .. n - 1
enum Act {{ stay, go(Col) }}
action act: Act
discount 0.9
param wall: bool[Col]
param k: 0 .. 99
fn inside(c: int): bool = c >= 0 and c < n
fn idiom(a: Col, b: Col, x: float): {type} = {body}
"""

GOOD = [
    ("Col", "if a > 0 then a - 1 else 0"),
    ("Col", "if a == n - 1 then 0 else a + 1"),
    ("Col", "if a != n - 1 then a + 1 else 0"),
    ("Col", "if a > b then a - b else b - a"),
    ("Col", "if b <= a then a - b else 0"),
    ("Col", "if a + b < n then a + b else 0"),
    ("Col", "if a + b < n and a + b > 2 then a + b - 3 else 0"),
    ("Col", "if a + 3 < n then a + 3 else 0"),
    ("0 .. 4", "if a + 3 < n then a else 0"),
    ("Col", "if inside(k) then k else 0"),
    ("Col", "if inside(a - b) then a - b else 0"),
    ("Col", "if not inside(k) then 0 else k"),
    ("Col", "if k < 0 or k >= n then 0 else k"),
    ("Col", "match k { 0 | 1 | 5 => k + 2  else => 0 }"),
    ("Col", "if k == 3 or k == 5 then k else 0"),
    ("bool", "a + b < n and wall[a + b]"),
    ("bool", "a + b >= n or wall[a + b]"),
    ("Col", "if x >= 0 and x < n then floor(x) else 0"),
    ("Col", "if x >= 0 and x <= 7 then ceil(x) else 0"),
    ("0 .. n", "count(c in Col where c >= a and c - a < 3 and wall[c - a])"),
    ("Col", "abs(a - b)"),
    ("Col", "(a + b) // 2"),
    ("Col", "(a + b) % n"),
    ("Col", "let d = a - b in if d > 0 then d else 0"),
    ("Col", "match act { go(c) => if c > 0 then c - 1 else c  stay => 0 }"),
]
BAD = [
    ("Col", "if a > b then b - a else 0"),
    ("Col", "if a + b < n then a + b + 1 else 0"),
    ("Col", "if k == 3 or k == 9 then k else 0"),
    ("Col", "if inside(k) or a > 2 then k else 0"),
    ("Col", "if x >= 0 and x <= n then floor(x) else 0"),
    ("Col", "if inside(k) then 0 else k"),
    ("bool", "wall[a + b] and a + b < n"),
]


def check(type_: str, body: str) -> None:
    text = FRAME.format(type=type_, body=body)
    source = Source("idiom.pomdp", text)
    lower(parse(source), {}, source)


@pytest.mark.parametrize(("type_", "body"), GOOD)
def test_a_condition_shows_that_a_value_fits(type_: str, body: str) -> None:
    check(type_, body)


@pytest.mark.parametrize(("type_", "body"), BAD)
def test_a_condition_that_does_not_show_it_is_not_taken_for_one(type_: str, body: str) -> None:
    with pytest.raises(ModelError) as caught:
        check(type_, body)
    assert {d.code for d in caught.value.diagnostics} <= {"E0601", "E0602"}
