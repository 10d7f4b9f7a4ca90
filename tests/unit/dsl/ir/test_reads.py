# SPDX-License-Identifier: Apache-2.0
"""What evaluating an expression comes to, through functions and lets."""

from hypgen.dsl import ir
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Int

HERE = Span("m.pomdp", 1, 1, 1, 2)
CELL = Int(0, 9)
K, ACT = ir.StateRead(CELL, "bot.k"), ir.ActionRead(CELL)
# let near = act; fn f(x: Cell): Cell = max(near, max(k, x))
NEAR = ir.Let("bot.near", "bot", None, ir.Certain(CELL, ACT), ir.Site("let:bot.near"), HERE)
BODY = ir.Binary(CELL, "max", ir.LetRead(CELL, "bot.near"), ir.Binary(CELL, "max", K, ir.Local(CELL, "x")))
F = ir.Function("f", (ir.Binder("x", CELL),), CELL, BODY, HERE)


def call(argument: ir.Expr, primed: bool = False) -> ir.Call:
    return ir.Call(CELL, "f", (argument,), primed)


def found(*nodes: ir.Expr) -> list[tuple[ir.Expr | ir.Dist, bool]]:
    return list(reached(nodes, {"f": F}, {"bot.near": NEAR}))


def test_bodies_come_before_arguments() -> None:
    kinds = [type(node).__name__ for node, _ in found(call(ir.Const(CELL, 1)))]
    assert kinds == [
        "Call",
        "Binary",
        "LetRead",
        "Certain",
        "ActionRead",
        "Binary",
        "StateRead",
        "Local",
        "Const",
    ]


def test_a_primed_call_primes_what_its_body_comes_to_and_not_its_arguments() -> None:
    argument = ir.StateRead(CELL, "bot.j")
    states = {
        node: primed for node, primed in found(call(argument, primed=True)) if node in (K, ACT, argument)
    }
    assert states == {K: True, ACT: True, argument: False}


def test_a_body_is_entered_once_as_it_is_and_once_primed() -> None:
    nested = call(call(call(K, primed=True)), primed=True)
    assert [primed for node, primed in found(nested) if node is BODY] == [True, False]


def test_what_is_not_given_is_not_entered() -> None:
    assert [type(node).__name__ for node, _ in reached((call(K),), {}, {})] == ["Call", "StateRead"]
