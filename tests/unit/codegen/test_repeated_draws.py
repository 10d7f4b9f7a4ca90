# SPDX-License-Identifier: Apache-2.0
"""A draw that an update reads several times is made once, and not where a simple condition spares it."""

from __future__ import annotations

from hypgen.codegen.generate import generate
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.ast import ModelFile
from hypgen.dsl.syntax.parse import parse

MODEL = """model Draws
discount 0.9
action act: bool
element e {{
  visible x: 0 .. 9
  hidden y: float
  init x = 0
  init y = 0
  let goes ~ bernoulli(0.5)
  let works = {works}
  x' = {x}
  y' = {y}
}}
reward step = if e.works then 1 else 0
observe seen: bool = e.y > 3
policy default = false
bound upper = 10
bound tail = 0
"""


def text(works: str = "goes", x: str = "x", y: str = "y") -> str:
    source = Source("draws.pomdp", MODEL.format(works=works, x=x, y=y))
    file = parse(source)
    assert isinstance(file, ModelFile)
    return generate(lower(file, {}, source))["src/draws.hpp"]


def body(function: str, *values: str) -> str:
    return text(*values).split(f" {function}(")[1].split("\n  }\n")[0].partition("{\n")[2]


TWICE = "if goes then y + 1 else if not goes and y > 3 then y else y - 1"


def test_a_draw_that_is_read_twice_is_made_once() -> None:
    assert "const bool goes = e_goes(draws);" in body("update_e", "goes", "x", TWICE)
    assert body("update_e", "goes", "x", TWICE).count("e_goes(") == 1


def test_a_draw_that_may_not_be_read_is_made_where_it_is() -> None:
    rare = "if y > 3 then (if goes and y > 2 then y + 1 else if goes then 1 else 2) else y"
    assert "const bool goes" not in body("update_e", "goes", "x", rare)


def test_what_is_simple_comes_before_a_draw() -> None:
    assert "return act && e_goes(draws);" in body("e_works", "goes and act")
    assert "return state.e_x() > 3 || e_goes(draws);" in body("e_works", "goes or x > 3")


def test_what_is_dear_comes_behind_a_draw() -> None:
    long = " + ".join(f"e.y * {n}" for n in range(2, 12))
    assert body("e_works", f"goes and {long} > 99").strip().startswith("return e_goes(draws) &&")
