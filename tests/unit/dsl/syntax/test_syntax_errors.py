# SPDX-License-Identifier: Apache-2.0
"""What the parser says of mistakes; the corpus (test_error_index.py) has one of each kind, word for word."""

import pytest

from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.parse import parse, parse_expression


def mistakes(text: str) -> tuple[Diagnostic, ...]:
    with pytest.raises(ModelError) as caught:
        parse(Source("m.pomdp", text))
    return caught.value.diagnostics


def model(line: str) -> str:
    """Put ``line`` on the second line of a model."""
    return f"model M\n{line}\n"


def test_a_large_integer_is_cut_from_no_message() -> None:
    (found,) = mistakes(model(f"horizon {'9' * 5000}"))
    assert found.span is not None and "32 bits" in found.remedy
    assert (found.code, found.span.line, found.span.column, found.span.end_column) == ("E0136", 2, 9, 5009)


def test_expected_is_in_the_authors_words() -> None:
    (found,) = mistakes(model("reward r ="))
    assert found.message == "the file ends too early: expected an expression"
    (found,) = mistakes('instance i "a" {}')
    assert found.message == "expected 'of'; found the text \"a\""
    (found,) = mistakes(model("reward r = (a)b"))
    assert found.message == "expected an operator or a declaration; found the name 'b'"


def test_unclosed_bracket_notes_what_comes_instead() -> None:
    (found,) = mistakes("model M\nelement e {\nterminal when a")
    ((span, text),) = found.notes
    assert (span.line, span.column, text) == (3, 1, "something else starts here")
    (found,) = mistakes(model("reward r = (1 + 2]"))
    ((span, text),) = found.notes
    assert (span.line, span.column, text) == (2, 12, "opened here")


@pytest.mark.parametrize(
    "text",
    [
        "+".join("x" * 300),
        "-" * 300 + "x",
        "if a then b else " * 300 + "x",
        "x" + "'" * 300,
        "f(" * 300 + "x" + ")" * 300,
    ],
    ids=["sum", "unary", "if", "prime", "call"],
)
def test_deep_nesting_is_a_diagnostic(text: str) -> None:
    with pytest.raises(ModelError) as caught:
        parse_expression(Source("e", text))
    assert [d.code for d in caught.value.diagnostics] == ["E0135"]


def test_parentheses_alone_are_no_depth() -> None:
    parse_expression(Source("e", "(" * 5000 + "x" + ")" * 5000))


@pytest.mark.parametrize("text", ["(" * 5000, ")" * 5000, "[" * 5000 + "x", "\x00", "é", "\\"])
def test_garbage_is_a_diagnostic(text: str) -> None:
    with pytest.raises(ModelError):
        parse_expression(Source("e", text))


def test_a_unit_that_does_not_end_is_a_mistake_and_not_a_crash() -> None:
    with pytest.raises(ModelError) as caught:
        parse(Source("m.pomdp", "model M\nconst a: float<1 m> = 2.0\n"))
    assert "expected '>'" in caught.value.diagnostics[0].message


@pytest.mark.parametrize(
    "line",
    [
        "discount 0.95  // per step",
        "discount 0.95  -- per step",
        "discount 0.95  % per step",
        "discount 0.95  /* per step */",
        "const n: int = 3 // how many: all of them",
        "const n: int = 3 // first.",
        "enum Act { stay, go } // what it does",
        "type Cell = 0 .. 3 // where it may be",
    ],
)
def test_a_comment_of_another_language_is_known(line: str) -> None:
    (found,) = mistakes(f"model M\n{line}\naction act: bool\nelement e {{\n}}\n")
    sign = next(s for s in ("//", "--", "/*", "%") if s in line)
    assert (found.code, found.message) == ("E0121", f"'{sign}' does not start a comment")
    assert found.span is not None and found.span.column == line.index(sign) + 1


@pytest.mark.parametrize(
    "line",
    [
        "reward r = x // 2 +",
        "reward r = if x % 2 = 0 then 1 else 2",
        "reward r = x // 2 3",
        "reward r = x - - then 3",
        "reward r = x % n else y",
    ],
)
def test_an_operator_is_taken_for_no_comment(line: str) -> None:
    (found,) = mistakes(model(f"{line}\naction act: bool"))
    assert found.code != "E0121"


@pytest.mark.parametrize(
    ("line", "remedy"),
    [
        ("hidden p: P\n  p.x' = 1", "write `p' = p with { x = .. }`, which keeps its other fields"),
        ("hidden p: P\n  init p.y = 1", "write `init p = P(.., ..)`, its fields in order"),
        ("visible fixed a, p: P\n  p.y' = 1", "write `p' = p with { y = .. }`, which keeps its other fields"),
        ("hidden p: P\n  q.x' = 1", "write `x'` in element 'q'"),
        ("next p ~ uniform(P)", "write `p' ~ ..`"),
        ("init p = P(y: 2, x: 1 + 1)", "write `P(1 + 1, 2)`"),
        ("init p = P(x = f(1), y = 2)", "write `P(x, y)`"),
    ],
)
def test_the_form_that_was_meant_is_shown(line: str, remedy: str) -> None:
    (found,) = mistakes(f"model M\nrecord P {{ x, y: 0 .. 3 }}\nelement e {{\n  {line}\n}}\n")
    assert found.remedy == remedy


@pytest.mark.parametrize(
    ("variant", "remedy"),
    [
        ("move[Obj]", "write `move(Obj)`"),
        ("move[0 .. 3]", "write `move(0 .. 3)`"),
        ("move(Obj, Obj)", "write `move(Pair)` with `record Pair { a: Obj, b: Obj }`"),
    ],
)
def test_what_a_variant_carries_is_one_value_in_parentheses(variant: str, remedy: str) -> None:
    (found,) = mistakes(model(f"enum Act {{ wait, {variant} }}"))
    assert (found.code, found.remedy) == ("E0147", remedy)
