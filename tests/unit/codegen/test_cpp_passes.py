# SPDX-License-Identifier: Apache-2.0
"""Passes over C++: loops of one trip, equal neighbours, first values, last writes, functions alike."""

from __future__ import annotations

from hypgen.codegen.tree.expr import FALSE, TRUE, Expr, Literal, call, method, number, of, op
from hypgen.codegen.tree.lines import head_of, statements
from hypgen.codegen.tree.passes import called, tidy
from hypgen.codegen.tree.sharing import renamed, share
from hypgen.codegen.tree.statements import (
    BREAK,
    Do,
    For,
    Function,
    Return,
    Statement,
    assign,
    const,
    for_range,
    var,
    when,
)

STEP = Function("void", "update", [("const State&", "state"), ("State&", "next"), ("std::int32_t", "i")], [])
GIVEN = [("const State&", "state"), ("State&", "next"), ("int", "act")]


def tidied(*body: Statement) -> list[str]:
    [_, function] = tidy([STEP, Function("void", "f", GIVEN, [*body])])
    return list(statements(function.body))


def update(i: int) -> Do:
    return Do(call("update", "state", "next", i))


def loop(first: int, last: int, *body: Statement) -> For:
    head = for_range("i", first, last)
    head.body.extend(body)
    return head


def test_a_loop_of_one_trip_is_its_body() -> None:
    body = Do(call("update", "state", "next", "i"))
    assert tidied(loop(3, 3, body)) == ["update(state, next, 3);"]
    assert len(tidied(loop(3, 4, body))) == 3


def test_a_loop_that_is_left_stays_a_loop() -> None:
    assert len(tidied(loop(3, 3, when("act", BREAK)))) == 3


def test_names_of_two_bodies_do_not_meet() -> None:
    body = (const("int", "x", "i"), Do(call("update", "state", "next", "x")))
    assert tidied(loop(1, 1, *body), loop(2, 2, *body)).count("  const int x = i;") == 2


def test_equal_neighbours_are_one() -> None:
    test = op(method("state", "x"), "==", "act")
    assert tidied(when(test, update(1)), when(test, update(2))) == [
        "if (state.x() == act) {",
        "  update(state, next, 1);",
        "  update(state, next, 2);",
        "}",
    ]


def test_neighbours_stay_two_where_the_first_may_change_the_answer() -> None:
    test = op(method("next", "x"), "==", "act")
    assert len(tidied(when(test, update(1)), when(test, update(2)))) == 2
    act = op("act", "==", 1)
    assert len(tidied(when(act, assign("act", 2)), when(act, update(2)))) == 2
    drawn = call("dist::bernoulli", method("draws", "word", 1))
    assert len(tidied(when(drawn, update(1)), when(drawn, update(2)))) == 2
    assert len(tidied(when(act, Return(of("act"))), when(act, update(2)))) == 2


def test_neighbours_that_declare_the_same_constant_share_it() -> None:
    test, use = op("act", "==", 1), Do(call("update", "state", "next", "x"))
    entry, other = const("int", "x", method("state", "x")), const("int", "x", method("next", "x"))
    assert tidied(when(test, entry, use), when(test, entry, update(2))) == [
        "if (act == 1) {",
        "  const int x = state.x();",
        "  update(state, next, x);",
        "  update(state, next, 2);",
        "}",
    ]
    for first, second in ((entry, other), (other, other)):
        assert len(tidied(when(test, first, use), when(test, second, use))) == 8


def test_a_local_starts_with_what_its_neutral_value_is_combined_with() -> None:
    weight = [var("double", "w", Literal("1.0")), assign("w", call("one", "act"), "*=")]
    assert tidied(*weight, assign("w", call("two", "act"), "*="), Return(of("w"))) == [
        "double w = one(act);",
        "w *= two(act);",
        "return w;",
    ]
    digits = [var("int", "key", 0), assign("key", of("key") * 3 + of("act")), Return(of("key"))]
    assert tidied(*digits) == ["int key = act;", "return key;"]
    kept = [var("int", "key", 1), assign("key", of("key") * 3 + of("act")), Return(of("key"))]
    assert tidied(*kept) == ["int key = 1;", "key = key * 3 + act;", "return key;"]
    own = [var("double", "w", Literal("1.0")), assign("w", call("one", "w"), "*="), Return(of("w"))]
    assert len(tidied(*own)) == 3


def test_a_local_of_the_type_of_the_result_is_returned_at_once() -> None:
    function = Function("double", "f", GIVEN, [var("double", "w", call("two", "act")), Return(of("w"))])
    [tidy_one] = tidy([function])
    assert [*statements(tidy_one.body)] == ["return two(act);"]
    assert tidied(var("float", "w", call("two", "act")), Return(of("w"))) == [
        "float w = two(act);",
        "return w;",
    ]


def test_a_last_write_that_nothing_reads_goes() -> None:
    rest = [var("int", "rest", "act"), Do(call("update", "state", "next", "rest"))]
    assert tidied(*rest, assign("rest", 2, "/=")) == ["int rest = act;", "update(state, next, rest);"]
    assert tidied(*rest, when("act", assign("rest", 2, "/="))) == tidied(*rest)
    again = loop(0, 4, Do(call("update", "state", "next", "rest")), assign("rest", 2, "/="))
    assert "  rest /= 2;" in tidied(*rest, again)
    assert "rest /= 2;" in tidied(*rest, assign("rest", 2, "/="), Return(of("rest")))
    assert tidied(assign("next", "state")) == ["next = state;"]


def test_what_has_no_effect_goes() -> None:
    idle = [assign("all", TRUE, "&="), assign("any", FALSE, "|="), assign("sum", 0, "+=")]
    assert tidied(*idle, when(op("act", "==", 1), assign("sum", 0, "+="))) == []
    assert tidied(loop(0, 4, assign("sum", 0, "+="))) == []
    assert tidied(assign("sum", FALSE, "&="), assign("sum", 1, "+=")) == ["sum &= false;", "sum += 1;"]


def test_a_local_that_nothing_reads_goes() -> None:
    unread = [var("int", "x", 1), assign("x", method("state", "x"))]
    assert tidied(*unread) == []
    assert len(tidied(*unread, Return(of("x")))) == 3
    assert len(tidied(var("int", "x", method("rest", "take", 2)))) == 1
    assert len(tidied(var("int", "x", method("draws", "word", 2)))) == 1
    assert len(tidied(var("int", "x", call("settle", "next")))) == 1


def test_functions_without_a_call_are_found() -> None:
    one = Function("int", "one", [], [Return(number(1))])
    two = Function("int", "two", [], [Return(call("one"))])
    top = Function("int", "top", [], [Return(call("two"))])
    assert called([one, two, top], ["one", "two"]) == {"one", "two", "top"}
    assert called([one, two], ["one", "two"]) == set()


def test_functions_that_differ_in_numbers_are_one_template() -> None:
    def numbered(name: str, first: int, last: int, entry: int) -> Function:
        step: Expr = call("update", "state", "next", "i")
        body = [var("bool", "any", FALSE), loop(first, last, Do(step)), update(entry)]
        return Function("void", name, GIVEN[:2], body, (f"// From {first}.",))

    names = iter(("group", "other"))
    alike = [numbered("group_0", 0, 4, 7), numbered("group_1", 1, 5, 8)]
    found, instances = share([*alike, STEP], lambda base: next(names))
    assert [f.name for f in found] == ["group", "update"]
    assert found[0].comment == ("// <7, 0, 4>: From 0.", "// <8, 1, 5>: From 1.")
    assert head_of(found[0])[0] == "template <int entry, int first, int last>"
    assert list(statements(found[0].body))[1] == ("for (std::int32_t i = first; i <= last; ++i) {")
    user = Function("void", "f", [], [Do(call("group_1", "s"))])
    assert list(statements(renamed(user, instances).body)) == ["group<8, 1, 5>(s);"]
