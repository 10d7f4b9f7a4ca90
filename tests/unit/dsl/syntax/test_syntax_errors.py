"""Every known syntax mistake: its code and the exact place."""

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


def member(line: str) -> str:
    """Put ``line`` on the second line of a model, in an element that line 3 closes."""
    return f"model M element e {{\n{line}\n}}\n"


CASES = {
    # name: text, code, line, column, end column, part of the remedy
    "compare with one sign": (model("legal when act = sample"), "E0103", 2, 16, 17, "`==`"),
    "compare in a condition": (model("reward r = if x = 3 then 1 else 2"), "E0103", 2, 17, 18, "`==`"),
    "define with two signs": (model("const n: int == 3"), "E0134", 2, 14, 16, "one `=`"),
    "else missing at the end": (model("reward r = if x then 1"), "E0104", 2, 23, 24, "then a else b"),
    "else missing in a call": (model("reward r = f(if x then 1)"), "E0104", 2, 25, 26, "then a else b"),
    "else missing in an element": (member("x' = if x then 1\n init x = 0"), "E0104", 2, 11, 15, "else b"),
    "then missing": (model("reward r = if x { 1 } else { 2 }"), "E0105", 2, 17, 18, "if condition then"),
    "and of C": (model("legal when a && b"), "E0106", 2, 14, 16, "`and`"),
    "or of C": (model("legal when a || b"), "E0106", 2, 14, 16, "`or`"),
    "or of one bar": (model("legal when a | b"), "E0106", 2, 14, 15, "`or`"),
    "not of C": (model("legal when !b"), "E0106", 2, 12, 13, "`not`"),
    "semicolon": (model("discount 0.95;"), "E0107", 2, 14, 15, "leave it out"),
    "update outside": (model("x' = 3"), "E0108", 2, 1, 2, "inside the braces"),
    "variable outside": (model("hidden x: bool"), "E0108", 2, 1, 7, "inside the braces"),
    "let outside": (model("let x = 3"), "E0108", 2, 1, 4, "inside the braces"),
    "brace missing": ("model M\nelement e {\n\nterminal when a", "E0109", 2, 11, 12, "missing `}`"),
    "brace missing at the end": ("model M\nelement e {\nx' = x", "E0109", 3, 7, 8, "missing `}`"),
    "parenthesis missing": (model("reward r = (1 + 2\nreward q = 3"), "E0109", 2, 12, 13, "missing `)`"),
    "parenthesis missing in an element": (member("x' = f(x\ny' = 3"), "E0109", 2, 7, 8, "missing `)`"),
    "wrong closing bracket": (model("reward r = (1 + 2]"), "E0109", 2, 18, 19, "missing `)`"),
    "too many parentheses": (model("reward r = 1 + 2)"), "E0110", 2, 17, 18, "leave it out"),
    "too many braces": (model("action a: A }"), "E0110", 2, 13, 14, "leave it out"),
    "assignment of Pascal": (model("const n := 3"), "E0111", 2, 9, 11, "`=`"),
    "assignment of Pascal in an element": (member("x := 3"), "E0111", 2, 3, 5, "`=`"),
    "assignment of R": (member("x' <- 3"), "E0111", 2, 4, 6, "`~`"),
    "increment": (member("x' += 3"), "E0111", 2, 4, 6, "x' = x + 1"),
    "elif": (model("reward r = if a then 1 elif b then 2 else 3"), "E0112", 2, 24, 28, "else if"),
    "reserved constant": (model("const type: int = 3"), "E0113", 2, 7, 11, "type_"),
    "reserved variant": (model("enum Door { left,\n terminal }"), "E0113", 3, 2, 10, "terminal_"),
    "reserved operand": (model("reward r = memory + 1"), "E0113", 2, 12, 18, "memory_"),
    "reserved variable": (member("reward' = 3"), "E0113", 2, 1, 7, "reward_"),
    "reserved variable of the model": (member("type' = 3"), "E0113", 2, 1, 5, "type_"),
    "when missing": (model("terminal x == 3"), "E0114", 2, 10, 11, "terminal when"),
    "when missing before if": (model("legal if x then y else z"), "E0114", 2, 7, 9, "legal when"),
    "type of a constant": (model("const n = 3"), "E0115", 2, 9, 10, "n: type"),
    "type of a variable": (member("visible y"), "E0115", 3, 1, 2, "y: type"),
    "type of a formal": (model("fn f(x): int = 3"), "E0115", 2, 7, 8, "x: type"),
    "type of a result": (model("fn f(x: int) = 3"), "E0115", 2, 14, 15, "): type"),
    "drawn reward": (model("reward r ~ bernoulli(0.5)"), "E0116", 2, 10, 11, "let x ~"),
    "drawn bound": (model("bound upper ~ 3"), "E0116", 2, 13, 14, "write `=`"),
    "chained comparison": (model("legal when 0 <= x <= 3"), "E0117", 2, 19, 21, "and"),
    "bare if": (model("reward r = 1 + if x then 1 else 2"), "E0118", 2, 16, 18, "+ (if"),
    "conditional of C": (model("reward r = a ? b : c"), "E0119", 2, 14, 15, "if condition"),
    "text without an end": (model('const s: G = ["ab, 3]'), "E0120", 2, 15, 22, "close it"),
    "comment of C": (model("// the map"), "E0121", 2, 1, 3, "`#`"),
    "comment of C at the start": ("/* a */ model M", "E0121", 1, 1, 3, "`#`"),
    "number without a first digit": (model("discount .95"), "E0122", 2, 10, 13, "0.95"),
    "number without a last digit": (model("discount 1.\nhorizon 3"), "E0122", 2, 10, 12, "1.0"),
    "number with a separator": (model("horizon 1_000"), "E0122", 2, 9, 14, "digits only"),
    "update without a prime": (member("x = 3"), "E0123", 2, 1, 2, "`x' =`"),
    "variable without visibility": (member("y: bool"), "E0123", 2, 1, 2, "hidden y"),
    "declaration without a keyword": (model("n = 3"), "E0123", 2, 1, 2, "const"),
    "comma missing in an array": (model("const a: int[T] = [1 2]"), "E0124", 2, 22, 23, "`,`"),
    "comma missing in an enum": (model("enum A { x y }"), "E0124", 2, 12, 13, "`,`"),
    "arm with a colon": (model("reward r = match a { x: 3 }"), "E0125", 2, 23, 24, "=>"),
    "arm with an arrow": (model("reward r = match a { x -> 3 }"), "E0125", 2, 24, 26, "=>"),
    "arm of two patterns": (model("reward r = match a { x, y => 3 }"), "E0125", 2, 23, 24, "first | second"),
    "loop": (model("reward r = for i in T: 3"), "E0142", 2, 12, 15, "sum(i in"),
    "loop of Python": (model("reward r = sum(x[i] for i in T)"), "E0142", 2, 21, 24, "sum(i in"),
    "init of another element": (member("init other.x = 3"), "E0143", 2, 6, 11, "`init x` in element 'other'"),
    "update of another element": (member("other[3].x' = 3"), "E0143", 2, 1, 6, "`x'` in element 'other'"),
    "primed init": (member("init x' = 3"), "E0143", 2, 7, 8, "`init x`"),
    "set of values": (member("x' ~ {0, 1}"), "E0144", 2, 8, 9, "{ 0: 0.5, .. }"),
    "set of one name": (member("x' ~ uniform({a})"), "E0144", 2, 16, 17, "without braces"),
    "power of Matlab": (model("reward r = x ^ 2"), "E0106", 2, 14, 15, "`**`"),
    "number with a unit": (model("param v: float<m/s> = 0.5 m/s"), "E0122", 2, 27, 28, "leave it out"),
    "unit in an instance": ('instance i of "m.pomdp" { d = 50 m }', "E0122", 1, 34, 35, "leave it out"),
    "unit in an element": (member("init x = -0.5 m\n x' = x"), "E0122", 2, 15, 16, "leave it out"),
    "memory without a prime": (model("policy default { n = 1 }"), "E0123", 2, 18, 19, "memory holds next"),
    "return of a policy": (model("policy default { return go }"), "E0123", 2, 18, 24, "choose = action"),
    "import without quotes": (model("import grids"), "E0101", 2, 8, 13, 'import "library.pomdp"'),
    "no model line": ("const n: int = 3", "E0126", 1, 1, 6, "model Name"),
    "only a comment": ("# nothing\n", "E0100", 1, 1, 2, "model Name"),
    "indexed update": (member("x[r]' = 3"), "E0128", 2, 2, 3, "x' = [i in"),
    "indexed init": (member("init x[r] = 3"), "E0128", 2, 7, 8, "init x = [i in"),
    "result arrow": (model("fn f(x: int) -> int = 3"), "E0129", 2, 14, 16, ": U"),
    "Cassandra's format": ("# Tiger\ndiscount: 0.95\nvalues: reward\n", "E0130", 2, 1, 10, "hypgen import"),
    "Cassandra's transitions": ("T: listen\nidentity\n", "E0130", 1, 1, 3, "hypgen import"),
    "POMDPX": ("<?xml version='1.0'?>\n<pomdpx>", "E0131", 1, 1, 6, "hypgen import"),
    "negative pattern": (model("reward r = match a { 0 => 3 -1 => 4 }"), "E0132", 2, 29, 31, "`,`"),
    "large integer": (model(f"horizon {'9' * 5000}"), "E0136", 2, 9, 5009, "32 bits"),
    "large number": (model("discount 1e999"), "E0136", 2, 10, 15, "float32"),
    "misspelt quantifier": (model("reward r = summ(r in Rock: 3)"), "E0137", 2, 12, 16, "'sum'"),
    "quantifier without a body": (model("reward r = sum(r in Rock)"), "E0138", 2, 12, 26, "sum(r in Rock:"),
    "number with two points": (model("discount 0.9.5"), "E0122", 2, 10, 15, "0.9"),
    "comment of C after a type": (model("action a: A\n// x y"), "E0121", 3, 1, 3, "`#`"),
    "misspelt keyword": (model("rewad r = 3"), "E0141", 2, 1, 6, "`reward`"),
    "misspelt keyword after an expression": (model("horizon 3\nelment e { }"), "E0141", 3, 1, 7, "`element`"),
    "misspelt keyword of an element": (member("hiden x: bool"), "E0141", 2, 1, 6, "`hidden`"),
    "lookalike character": (model("legal when a ≤ b"), "E0102", 2, 14, 15, "`<=`"),
    "unknown character": (model("legal when a @ b"), "E0102", 2, 14, 15, "letters"),
    "missing name": (model("reward = 3"), "E0101", 2, 8, 9, "reward name = expression"),
    "missing expression": (model("reward r =\nhorizon 3"), "E0101", 3, 1, 8, "reward name = expression"),
    "instance with a colon": ('instance i of "a" { n: 3 }', "E0101", 1, 22, 23, "instance name of"),
    "binder of C": (model("reward r = sum(T i: 2)"), "E0145", 2, 16, 19, "`sum(i in T: ..)`"),
    "binder with a colon": (model("reward r = any(i: T: x)"), "E0145", 2, 16, 18, "`any(i in T: ..)`"),
    "binder without a name": (model("reward r = sum(T: 2)"), "E0145", 2, 16, 18, "`sum(i in T: ..)`"),
    "binder without a type": (model("reward r = sum(i: 2)"), "E0145", 2, 16, 18, "`sum(i in Type: ..)`"),
    "binder of a loop": (model("reward r = sum(int i = 0 .. 3: 2)"), "E0145", 2, 16, 19, "i in Type"),
    "binder of a range": (model("reward r = sum(i = 0 .. 3: 2)"), "E0145", 2, 16, 19, "i in low .. high"),
    "binder of an array": (member("x' = [T i: 2]"), "E0145", 2, 7, 10, "`[i in T: ..]`"),
    "binder with if": (model("reward r = sum(i in T if c: 2)"), "E0145", 2, 23, 25, "`sum(i in T where"),
    "body after a comma": (model("reward r = sum(i in T, f(i))"), "E0145", 2, 24, 25, "`sum(i in T: ..)`"),
    "number after a comma": (model("reward r = sum(i in T, 2)"), "E0145", 2, 24, 25, "`sum(i in T: ..)`"),
    "body behind": (model("reward r = sum(i in T) x[i]"), "E0145", 2, 24, 25, "`sum(i in T: ..)`"),
    "record in braces": (
        model("record P { x, y: T z: U } const p: P = P { 1 }"),
        "E0146",
        2,
        40,
        43,
        "`P(x, y, z)`",
    ),
    "record with names": (model("record P { x: T } const p: P = P(x = 1)"), "E0146", 2, 34, 37, "`P(x)`"),
    "argument with a name": (
        model("fn f(a: T, b: U): T = a reward r = f(1, b = 2)"),
        "E0146",
        2,
        41,
        44,
        "`f(a, b)`",
    ),
    "tuple": (model("reward r = (1, 2)"), "E0146", 2, 14, 15, "`Name(a, b)`"),
    "family of a type": (model("element e[T i] { }"), "E0145", 2, 11, 14, "`element e[i in T]`"),
    "family without a name": (model("element e[T] { }"), "E0145", 2, 11, 12, "`element e[i in T]`"),
    "type first": (model("const int n = 3"), "E0147", 2, 7, 10, "`n: int`"),
    "type first in an element": (member("visible T x"), "E0147", 2, 9, 12, "`x: T`"),
    "type of a formal first": (model("fn f(P a, P b): int = 3"), "E0147", 2, 6, 9, "`a: P`"),
    "type of a field first": (model("record P { int x }"), "E0147", 2, 12, 15, "`x: int`"),
    "variant with a colon": (model("enum A { move: D, stay }"), "E0147", 2, 14, 15, "`move(D)`"),
    "variable with a value": (member("visible x: 0 .. 9 = 3"), "E0148", 2, 19, 20, "`init x = ..`"),
    "variable with a draw": (member("hidden fixed x: T ~ uniform(T)"), "E0148", 2, 19, 20, "`init x ~ ..`"),
    "function of Python": (model("def f(a, b): a"), "E0149", 2, 1, 4, "`fn name(x: type)"),
    "return": (model("fn f(a: T): T = return a"), "E0149", 2, 17, 23, "leave it out"),
    "method": (model("reward r = e.x.far(y)"), "E0149", 2, 16, 19, "`far(..)`"),
    "in of Python": (
        model("reward r = if act in [a, b] then 1 else 0"),
        "E0149",
        2,
        19,
        21,
        "x == a or x == b",
    ),
    "increment of C": (member("x' = if a then x++ else x"), "E0111", 2, 17, 19, "`x + 1`"),
    "range of values": (member("x' ~ uniform(1 .. 6)"), "E0150", 2, 16, 18, "`uniform(1, 6)`"),
    "percentage": (model("param p: prob = 80%\ndiscount 0.9"), "E0122", 2, 17, 20, "`0.8`"),
    "pattern with a type": (model("reward r = match a { x(T i) => 3 }"), "E0125", 2, 24, 27, "`x(i) =>"),
    "switch of C": (model("reward r = switch (act) { a => 1 }"), "E0149", 2, 12, 18, "`match value"),
    "conditional of Python": (model("reward r = f(x) if c else 0"), "E0149", 2, 17, 19, "if condition then"),
    "pattern with its enum": (model("reward r = match a { A.x => 3 }"), "E0125", 2, 22, 24, "`x`"),
    "discount by its symbol": (model("gamma = 0.9"), "E0149", 2, 1, 6, "discount 0.95"),
    "state in a library": ("library L\nelement e { }", "E0139", 2, 1, 14, "move it to the model"),
}


@pytest.mark.parametrize("name", CASES)
def test_mistake_has_its_code_place_and_remedy(name: str) -> None:
    text, code, line, column, end_column, remedy = CASES[name]
    (found,) = mistakes(text)
    assert found.span is not None
    at = (found.code, found.span.line, found.span.column, found.span.end_column)
    assert at == (code, line, column, end_column)
    assert remedy in found.remedy


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
