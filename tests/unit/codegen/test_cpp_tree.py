# SPDX-License-Identifier: Apache-2.0
"""The tree of C++ and its text."""

from __future__ import annotations

import pytest

from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import (
    Choice,
    Expr,
    Literal,
    Name,
    Postfix,
    Prefix,
    braces,
    call,
    member,
    method,
    not_,
    number,
    of,
    op,
    plus,
    shifted,
)
from hypgen.codegen.tree.lines import head_of, statements, text_of
from hypgen.codegen.tree.statements import (
    Comment,
    Declare,
    Do,
    Function,
    Return,
    assign,
    const,
    for_below,
    names_in,
    when,
)

A, B, C = map(Name, "abc")


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (A + B * C, "a + b * c"),
        ((A + B) * C, "(a + b) * c"),
        (A - (B - C), "a - (b - c)"),
        (A - B - C, "a - b - c"),
        (plus(A, B - C), "a + b - c"),
        (A / (B * C), "a / (b * c)"),
        (op(op(A, "&&", B), "||", C), "(a && b) || c"),
        (op(op(A, "&&", B), "&&", C), "a && b && c"),
        (op(A, "&&", op(B, "&&", C)), "a && b && c"),
        (op(not_(A), "==", B), "(!a) == b"),
        (op(op(A, "==", B), "==", C), "(a == b) == c"),
        (op(op(A, ">>", 3), "&", 7) + B, "(a >> 3 & 7) + b"),
        (Prefix("-", Prefix("-", A)), "-(-a)"),
        (Prefix("-", Literal("-1.0f")), "-(-1.0f)"),
        (not_(op(A, "<", B)), "!(a < b)"),
        (Choice(op(A, "<", B), A, Choice(B, A, C)), "a < b ? a : (b ? a : c)"),
        (op(Postfix(A, "--"), "==", 0), "a-- == 0"),
        (Prefix("*", Postfix(A, "++")), "*a++"),
        (member(A, "x")[B + C], "a.x[b + c]"),
        (method(A, "f", braces("T", 1), "b"), "a.f(T{1}, b)"),
        (shifted(A, -2) % 3, "(a - 2) % 3"),
        (number(-(2**31)), "(-2147483647 - 1)"),
    ],
)
def test_parentheses_stand_where_they_are_needed(expr: Expr, text: str) -> None:
    assert text_of(expr) == text


def test_a_block_grows_where_it_is_open() -> None:
    code = Code()
    with code.block(for_below("i", 3)):
        with code.when(op("i", "<", "n")):
            code.add(assign("a", "i"))
        with code.or_when("b"):
            code.add(Comment("nothing"))
        with code.otherwise():
            code.add(Return(of("i")))
    with code.when("c"):
        code.add(Do(call("f")))
    code.join()
    assert list(statements(code.body)) == [
        "for (std::int32_t i = 0; i < 3; ++i) {",
        "  if (i < n) {",
        "    a = i;",
        "  } else if (b) {",
        "    // nothing",
        "  } else {",
        "    return i;",
        "  }",
        "}",
        "if (c) f();",
    ]


def test_a_statement_that_is_too_long_for_one_line_keeps_its_braces() -> None:
    short = when("c", assign("a", Name("b" * 90)))
    long = when("c", assign("a", Name("b" * 110)))
    assert len(list(statements([short]))) == 1
    assert next(statements([long])) == "if (c) {"


def test_declarations() -> None:
    body = [
        Declare("dist::Masses", "sums"),
        Declare("float", "x", braces("")),
        Declare("double", "all", braces(""), (2,)),
        Declare("const int", "seen", number(1), unused=True),
        Declare("Walk", "walk", arguments=(A,)),
    ]
    assert list(statements(body)) == [
        "dist::Masses sums;",
        "float x{};",
        "double all[2] = {};",
        "[[maybe_unused]] const int seen = 1;",
        "Walk walk(a);",
    ]


def test_arguments_without_use_have_no_name() -> None:
    body = [when("a", Return(member("x", "b")))]
    function = Function("int", "f", [("int", "a"), ("int", "b"), ("X", "x")], list(body))
    assert head_of(function) == ["HYPGEN_FN static int f(int a, int, X x) {"]
    assert names_in(function.body) == {"a", "x"}


def test_long_lines_break_between_operands_and_never_in_strings() -> None:
    total: Expr = Literal('"a, b = c ? d"')
    for n in range(20):
        total = total + call(f"summand_{n}", "x", Literal('"p, q + r"'))
    lines = list(statements([when("c", const("int", "total", total))]))
    assert len(lines) > 3
    assert all(len(line) <= 110 for line in lines)
    assert all(line.count('"') % 2 == 0 for line in lines)
    assert all(line.startswith("      ") for line in lines[2:-1])


def test_long_comments_do_not_break() -> None:
    assert len(list(statements([Comment("by one, two, " * 12)]))) == 1
