# SPDX-License-Identifier: Apache-2.0
"""Values, actions and entries as text."""

from __future__ import annotations

import pytest
from support import ir_samples

from hypgen.dsl import ir
from hypgen.dsl.interpret.value_text import (
    action_text,
    array_text,
    entry_names,
    factor_texts,
    find_action,
    value_text,
)
from hypgen.dsl.types import BOOL, FLOAT, Enum, Int, Record, Type, Variant

CELL = Record("Cell", (("row", Int(2, 4)), ("open", BOOL)))
ACT = Enum("Act", (Variant("stay"), Variant("check", Int(-1, 12)), Variant("go", CELL), Variant("stop")))


@pytest.mark.parametrize(
    ("value", "type_", "text"),
    [
        (True, BOOL, "true"),
        (-3, Int(-5, 5), "-3"),
        (0.1, FLOAT, "0.1"),
        (3, CELL, "Cell(3, true)"),
        (0, ACT, "stay"),
        (1, ACT, "check(-1)"),
        (14, ACT, "check(12)"),
        (16, ACT, "go(Cell(2, true))"),
        (21, ACT, "stop"),
    ],
)
def test_values(value: int, type_: Type, text: str) -> None:
    assert value_text(value, type_) == text


def action(type_: Type, *indices: Type) -> ir.Action:
    return ir.Action("act", type_, indices, ir_samples.span(1))


def test_joint_actions() -> None:
    joint = action(Enum("Move", (Variant("left"), Variant("right"))), BOOL)
    assert [action_text(code, joint) for code in range(4)] == [
        "(left, left)",
        "(left, right)",
        "(right, left)",
        "(right, right)",
    ]
    assert find_action("l r", joint) == [1]
    assert find_action("r", joint) == []


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("check(1)", [3]),
        ("ch 1", [3]),
        ("c -1", [1]),
        ("st", [0, 21]),
        ("stop", [21]),
        ("go 3 true", []),
        ("", []),
    ],
)
def test_actions_can_be_abbreviated(text: str, codes: list[int]) -> None:
    assert find_action(text, action(ACT)) == codes


def test_arrays() -> None:
    assert array_text([1, 2, 3, 4, 5, 6], Int(0, 9), (BOOL, Int(1, 3))) == "[\n  [1, 2, 3],\n  [4, 5, 6]\n]"
    assert (
        array_text([True, False], BOOL, (Enum("E", (Variant("a"), Variant("b"))),)) == "[a: true, b: false]"
    )
    model = ir_samples.wanderer()
    names = [entry_names(v.name, v.element, v.indices, model) for v in model.variables]
    assert "map.wall[1]" in names[0]
    assert ["bot[0].at", "bot[1].at"] in names
    assert entry_names("seen", None, (BOOL,), model) == ["seen[false]", "seen[true]"]


def test_a_factors_values() -> None:
    model = ir_samples.rocks()
    rock = next(e for e in model.elements if e.binder is not None)
    hidden = tuple(v.name for v in model.variables if v.element == rock.name and not v.visible)
    factor = ir.Factor(rock.name, rock.binder, hidden, 2 ** len(hidden), "", ())
    texts = factor_texts(factor, model)
    assert len(texts) == factor.members
    assert texts[1] == ("rock[1].good", ["false", "true"])
    pair = ir.Factor("bot", ir.Binder("b", Int(0, 1)), ("bot.at", "bot.seen"), 25, "", ())
    label, values = factor_texts(pair, ir_samples.wanderer())[1]
    assert (label, values[7]) == ("bot[1]", "at = 2, seen = 3")
