# SPDX-License-Identifier: Apache-2.0
"""Tables for formulas under conditions: nothing is read where its index may be out of range."""

import pytest

from hypgen.codegen.generate import generate
from hypgen.codegen.passes.hoisting import Hoisting
from hypgen.dsl import ir
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse
from hypgen.dsl.types import Int

MODEL = """model M
type Cell = 0 .. 9
enum Act {{ wait, go }}
discount 0.9
action act: Act
param slope: float = 0.5
element bot {{
  hidden k: Cell
  init k = 0
  k' = clamp(k + 1)
}}
reward r = {reward}
bound upper = 0
bound tail = 0
"""


@pytest.mark.parametrize(
    ("reward", "statement"),
    [
        ("if bot.k > 6 and act == go then log(bot.k - 6) else 0.0", "params.r_table[state.bot_k() - 7]"),
        ("if bot.k > 6 then log(bot.k - 6) * slope else 0.0", "return params.r_table[state.bot_k()];"),
    ],
)
def test_a_table_is_as_large_as_what_reaches_it(reward: str, statement: str) -> None:
    source = Source("m.pomdp", MODEL.format(reward=reward))
    header = generate(lower(parse(source), {}, source))["src/m.hpp"]
    body = header[header.index("static float reward_r(") :]
    body = body[: body.index("\n  }\n")]
    assert statement in body
    if "act" in reward:
        assert body.index("act == Act::go") < body.index(statement)


def test_no_entry_is_read_before_the_condition_that_keeps_its_index_in_range() -> None:
    text = MODEL.format(reward="if wet_at(bot.k + 4) then 1 else 0").replace(
        "element bot", "fn wet_at(c: int): bool = at(sea.wet, c, false)\nelement bot"
    )
    sea = "element sea {\n  hidden fixed wet: bool[Cell]\n  init wet ~ [c in Cell: bernoulli(0.5)]\n}\n"
    source = Source("m.pomdp", text + sea)
    header = generate(lower(parse(source), {}, source))["src/m.hpp"]
    without_bounds = header.replace("group_0_table", "").replace("earned_table", "")
    assert "_table" not in without_bounds


@pytest.mark.parametrize(
    ("local", "declaration"),
    [
        ("f", "fn half(f: Cell): float = f * 0.5"),
        (
            "i",
            "element bits { hidden on: bool[Cell]\n init on = [i in Cell: true]\n on' = [i in Cell: on[i]] }",
        ),
        ("w", "element drawn { hidden n: Cell\n init n = 0\n n' ~ weighted(w in Cell: 1.0 + w) }"),
        ("q", "reward several = count(q in Cell where q == bot.k)"),
    ],
)
def test_a_narrowed_local_is_safe_nowhere(local: str, declaration: str) -> None:
    """Whatever declares the local: the model, a distribution or an expression."""
    text = MODEL.format(reward="0.0").replace("element bot", f"{declaration}\nelement bot")
    source = Source("m.pomdp", text)
    hoisting = Hoisting(lower(parse(source), {}, source))
    assert hoisting.is_safe(ir.Local(Int(0, 9), local))
    assert not hoisting.is_safe(ir.Local(Int(5, 9), local))
