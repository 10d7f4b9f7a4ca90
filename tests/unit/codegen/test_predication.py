# SPDX-License-Identifier: Apache-2.0
"""Functions in lanes: masks in place of branches, or a reason why there are none."""

from __future__ import annotations

import pytest

from hypgen.codegen.lanes.lane_text import NoLanes
from hypgen.codegen.lanes.predication import predicated
from hypgen.codegen.lanes.repeated_calls import without_repeated_calls
from hypgen.codegen.tree.expr import Literal, Name, Postfix, call, number, of, op
from hypgen.codegen.tree.lines import statements
from hypgen.codegen.tree.statements import (
    CONTINUE,
    Block,
    Function,
    Return,
    Statement,
    assign,
    const,
    for_below,
    var,
    when,
)

X = ("std::int32_t", "x")


def lines(*functions: Function) -> list[str]:
    """Return the lines of the last function in lanes."""
    return [*statements(without_repeated_calls(predicated(functions))[-1].body)]


def function(*body: Statement, result: str = "std::int32_t", name: str = "f") -> Function:
    return Function(result, name, [X], Block(body))


def test_a_return_in_a_branch_takes_its_lanes_out() -> None:
    early = function(when(op("x", ">", 0), Return(number(1))), Return(number(2)))
    assert lines(early) == [
        "lanes::Lanes<std::int32_t> result;",
        "lanes::Mask done = false;",
        "const lanes::Mask on_2 = lanes::both(on, x > 0);",
        "assign(on_2, result, 1);",
        "done = lanes::either(done, on_2);",
        "const lanes::Mask on_3 = lanes::without(on, done);",
        "if (lanes::any(on_3)) {",
        "  assign(on_3, result, 2);",
        "  done = lanes::either(done, on_3);",
        "}",
        "return result;",
    ]


def test_a_local_is_assigned_in_all_lanes_and_in_a_branch_in_its_own() -> None:
    made = lines(
        function(
            var("std::int32_t", "y", 0),
            assign("y", 3, "+="),
            when(op("x", ">", 0), assign("y", "x")),
            Return(of("y")),
        )
    )
    assert made[1] == "y = y + 3;"
    assert "assign(on_2, y, x);" in made


def test_a_lane_that_skips_a_trip_is_there_in_the_next_one() -> None:
    loop = for_below("i", 3)
    loop.body += [when(op("x", "==", "i"), CONTINUE), assign("y", 1, "+=")]
    made = lines(function(var("std::int32_t", "y", 0), loop, Return(of("y"))))
    assert made[1:] == [
        "for (std::int32_t i = 0; i < 3; ++i) {",
        "  const lanes::Mask on_2 = on;",
        "  lanes::Mask skipped = false;",
        "  const lanes::Mask on_3 = lanes::both(on_2, x == i);",
        "  skipped = lanes::either(skipped, on_3);",
        "  const lanes::Mask on_4 = lanes::without(on_2, skipped);",
        "  if (lanes::any(on_4)) assign(on_4, y, y + 1);",
        "}",
        "return y;",
    ]


def test_what_changes_something_is_left_out_in_lanes_that_do_not_come_to_it() -> None:
    counted = op(op("x", ">", 0), "&&", op(Postfix(Name("left"), "--"), "==", 0))
    made = lines(
        function(var("std::int32_t", "left", 2), when(counted, assign("left", 9)), Return(of("left")))
    )
    assert "lanes::stepped(lanes::both(on, x > 0), left, -1)" in " ".join(line.strip() for line in made)


def test_a_call_that_repeats_is_made_once() -> None:
    inner = function(Return(of("x")), name="inner")
    twice = function(const("std::int32_t", "y", call("inner", "x")), Return(op("y", "+", call("inner", "x"))))
    assert lines(inner, twice) == [
        "const auto inner_now = inner(on, x);",
        "const auto y = lanes::as<std::int32_t>(inner_now);",
        "return y + inner_now;",
    ]


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ([for_below("i", "x")], "f has a loop whose length varies"),
        ([Return(call("dist::density", Literal("1.0f")))], "f calls dist::density"),
        ([var("dist::WeightSum", "all", 0)], "f keeps a dist::WeightSum"),
    ],
)
def test_what_has_no_lanes_is_named(body: list[Statement], reason: str) -> None:
    with pytest.raises(NoLanes, match=reason):
        predicated([function(*body)])
