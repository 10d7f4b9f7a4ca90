# SPDX-License-Identifier: Apache-2.0
"""What calls and lets stand for: arguments keep their meaning, whatever the body binds."""

from hypgen.dsl import ir
from hypgen.dsl.ir.inline import Inliner, certain, unnamed
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import BOOL, Int

HERE = Span("m.pomdp", 1, 1, 1, 2)
CELL = Int(0, 9)
CELL_I, X = ir.Local(CELL, "i"), ir.Local(CELL, "x")


def read(*indices: ir.Expr, primed: bool = False) -> ir.StateRead:
    return ir.StateRead(CELL, "bot.k", indices, primed)


def equal(a: ir.Expr, b: ir.Expr) -> ir.Binary:
    return ir.Binary(BOOL, "eq", a, b)


def any_of(name: str, body: ir.Expr) -> ir.Quantified:
    return ir.Quantified(BOOL, "any", (ir.Binder(name, CELL),), None, body, None)


# fn taken(x: Cell): bool = any(i in Cell: k[i] == x)
TAKEN = ir.Function("taken", (ir.Binder("x", CELL),), BOOL, any_of("i", equal(read(CELL_I), X)), HERE)


def test_what_a_body_binds_captures_no_argument() -> None:
    inliner = Inliner({"taken": TAKEN}, {})
    call = ir.Call(BOOL, "taken", (CELL_I,))
    own = ir.Local(CELL, "i_1")
    assert inliner.call(call) == any_of("i_1", equal(read(own), CELL_I))
    assert inliner.call(call) == any_of("i_2", equal(read(ir.Local(CELL, "i_2")), CELL_I))


def test_a_primed_call_primes_the_body_and_not_the_arguments() -> None:
    call = ir.Call(BOOL, "taken", (read(CELL_I),), primed=True)
    own = ir.Local(CELL, "i_t1")
    expected = any_of("i_t1", equal(read(own, primed=True), read(CELL_I)))
    assert Inliner({"taken": TAKEN}, {}, mark="_t").call(call) == expected


def test_the_read_of_a_let_is_its_expression_or_its_distribution() -> None:
    member = ir.Binder("x", CELL)
    near = ir.Let(
        "bot.near", "bot", member, ir.Certain(BOOL, equal(X, CELL_I)), ir.Site("let:bot.near"), HERE
    )
    works = ir.Let("bot.works", "bot", member, ir.Bernoulli(BOOL, X), ir.Site("let:bot.works"), HERE)
    inliner = Inliner({}, {"bot.near": near, "bot.works": works})
    two = ir.Const(CELL, 2)
    assert inliner.let(ir.LetRead(BOOL, "bot.near", (two,))) == equal(two, CELL_I)
    assert inliner.let(ir.LetRead(BOOL, "bot.works", (two,))) == ir.Bernoulli(BOOL, two)


def test_a_local_let_is_its_body_with_the_value() -> None:
    assert unnamed(ir.LetIn(BOOL, "x", read(), equal(X, CELL_I))) == equal(read(), CELL_I)


def test_a_distribution_that_draws_nothing_is_an_expression() -> None:
    one, two = ir.Const(CELL, 1), ir.Const(CELL, 2)
    chosen = ir.IfDist(CELL, equal(X, CELL_I), ir.Certain(CELL, one), ir.Certain(CELL, two))
    assert certain(ir.LetDist(CELL, "x", read(), chosen)) == ir.LetIn(
        CELL, "x", read(), ir.If(CELL, equal(X, CELL_I), one, two)
    )
    assert certain(ir.IfDist(CELL, equal(X, CELL_I), ir.Certain(CELL, one), ir.Uniform(CELL))) is None
