# SPDX-License-Identifier: Apache-2.0
"""The syntax tree: its nodes, what binds tighter, and exact spans."""

from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse, parse_expression

MODELS = sorted(EXAMPLES.glob("*.pomdp"))

EVERYTHING = """model Everything                     # a comment
const n: int = 3
const grid: Cell[Row, 0 .. n] = ["ab", "cd"]
param speed: float<m/s^2>[Row]
type Row = -1 .. n * (2 + k) - 1
enum Cell { wall "#", go(Row), stay, }
record Pos { row, col: Row, flag: bool }
fn f(a: Row, b: float): prob = a
fn g(): Row ~ uniform(Row)
action act: Cell[Row]
discount 0.95
horizon 90
observe z: bool ~ noisy(true, 0.8)
reward r = 1
terminal when a
legal when b
success when c
policy default ~ {a: 0.5, else b}
bound tail = 0
element e[i in Row] {
  visible fixed x, y: Row
  hidden bits: bool[Row]
  init x = 0
  let t: Row ~ uniform(Row)
  let u = t
  x' = x
  bits' ~ [r in Row: bernoulli(0.5)]
  observe w: bool = x' == 1
  reward q = 2
}
"""


def expression(text: str) -> ast.Expr:
    return parse_expression(Source("e", text))


def shape(node: object) -> object:
    """Return a tree as nested tuples without spans."""
    match node:
        case ast.Literal(value=value):
            return value
        case ast.Name(name=name):
            return name
        case ast.Node():
            values = [shape(v) for k, v in vars(node).items() if k != "span"]
            return (type(node).__name__, *values)
        case tuple():
            return tuple(shape(n) for n in node)
    return node


def model(text: str) -> ast.ModelFile:
    file = parse(Source("m", text))
    assert isinstance(file, ast.ModelFile)
    return file


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_examples_parse(path: Path) -> None:
    parse(Source(path.name, path.read_text()))


def test_every_item_becomes_its_node() -> None:
    kinds = [type(i).__name__ for i in model(EVERYTHING).items]
    assert kinds == [
        "Const", "Const", "Param", "TypeAlias", "EnumDecl", "RecordDecl", "Function", "Function", "Action",
        "Setting", "Setting", "Observe", "Reward", "Condition", "Condition", "Condition", "Policy", "Bound",
        "Element",
    ]  # fmt: skip
    element = model(EVERYTHING).items[-1]
    assert isinstance(element, ast.Element)
    assert [type(m).__name__ for m in element.members] == [
        "Variable", "Variable", "Variable", "Init", "Let", "Let", "Update", "Update", "Observe",
        "Reward",
    ]  # fmt: skip


def test_details_of_declarations() -> None:
    items = model(EVERYTHING).items
    assert shape(items[1]) == (
        "Const",
        "grid",
        ("TypeArray", ("TypeName", "Cell", None), (("TypeName", "Row", None), ("TypeRange", 0, "n"))),
        ("ArrayLiteral", ("ab", "cd")),
    )
    speed_type = ("TypeArray", ("TypeName", "float", "m/s^2"), (("TypeName", "Row", None),))
    assert shape(items[2]) == ("Param", "speed", speed_type, None)
    low, high = ("Unary", "-", 1), ("Binary", "-", ("Binary", "*", "n", ("Binary", "+", 2, "k")), 1)
    assert shape(items[3]) == ("TypeAlias", "Row", ("TypeRange", low, high))
    enum = items[4]
    assert isinstance(enum, ast.EnumDecl)
    assert [(v.name, v.argument is not None, v.glyph) for v in enum.variants] == [
        ("wall", False, "#"),
        ("go", True, None),
        ("stay", False, None),
    ]
    record = items[5]
    assert isinstance(record, ast.RecordDecl)
    assert [f.name for f in record.fields] == ["row", "col", "flag"]
    assert isinstance(items[7], ast.Function) and items[7].rhs.draw and items[7].formals == ()
    element = items[-1]
    assert isinstance(element, ast.Element) and element.binder is not None
    x, y, bits = (m for m in element.members if isinstance(m, ast.Variable))
    assert (x.visible, x.fixed, x.name, y.name) == (True, True, "x", "y")
    assert (bits.visible, bits.fixed) == (False, False)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a + b * c", ("Binary", "+", "a", ("Binary", "*", "b", "c"))),
        ("a - b - c", ("Binary", "-", ("Binary", "-", "a", "b"), "c")),
        ("(a - b) // c % d", ("Binary", "%", ("Binary", "//", ("Binary", "-", "a", "b"), "c"), "d")),
        ("-a ** -b", ("Unary", "-", ("Binary", "**", "a", ("Unary", "-", "b")))),
        ("2 ** 3 ** 4", ("Binary", "**", 2, ("Binary", "**", 3, 4))),
        (
            "not a == b and c or d",
            ("Binary", "or", ("Binary", "and", ("Unary", "not", ("Binary", "==", "a", "b")), "c"), "d"),
        ),
        ("a.b[c, d]'", ("Prime", ("Index", ("Member", "a", "b"), ("c", "d")))),
        ("f()'", ("Prime", ("Call", "f", ()))),
        ("f(a, 1.5e3)", ("Call", "f", ("a", 1500.0))),
        ("if a then b else if c then d else e", ("If", "a", "b", ("If", "c", "d", "e"))),
        ("let k = a in k + 1", ("LetIn", "k", "a", ("Binary", "+", "k", 1), False, None)),
        ("let k: T ~ a in k", ("LetIn", "k", "a", "k", True, ("TypeName", "T", None))),
        ("{a: 0.5, b: 0.5,}", ("TableLiteral", (("a", 0.5), ("b", 0.5)), None)),
        ("{a: 0.5, else b}", ("TableLiteral", (("a", 0.5),), "b")),
        ("{else b,}", ("TableLiteral", (), "b")),
        ("[]", ("ArrayLiteral", ())),
        ("[a, [b],]", ("ArrayLiteral", ("a", ("ArrayLiteral", ("b",))))),
        (
            "[i in T, j in U: i]",
            (
                "Comprehension",
                (("Binder", "i", ("TypeName", "T", None)), ("Binder", "j", ("TypeName", "U", None))),
                "i",
            ),
        ),
        (
            "uniform(p in 0 .. 3 where f(p): a else b)",
            (
                "Quantified",
                "uniform",
                (("Binder", "p", ("TypeRange", 0, 3)),),
                ("Call", "f", ("p",)),
                "a",
                "b",
            ),
        ),
        (
            "count(r in T)",
            ("Quantified", "count", (("Binder", "r", ("TypeName", "T", None)),), None, None, None),
        ),
    ],
)
def test_expressions(text: str, expected: object) -> None:
    assert shape(expression(text)) == expected


def test_patterns_of_a_match() -> None:
    tree = expression("match x { a | b => 1  c(r) => 2, -1 | 2 => 3, true => 4  else => 5, }")
    assert isinstance(tree, ast.Match)
    patterns = [[(p.name, p.argument, p.value) for p in arm.patterns] for arm in tree.arms]
    assert patterns[:3] == [
        [("a", None, None), ("b", None, None)],
        [("c", "r", None)],
        [(None, None, -1), (None, None, 2)],
    ]
    assert patterns[3][0][2] is True
    assert tree.arms[4].patterns[0].is_else


def test_literals_have_their_python_types() -> None:
    values = [expression(t).value for t in ("3", "3.0", "true", '"#."')]  # type: ignore[attr-defined]
    assert [(v, type(v)) for v in values] == [(3, int), (3.0, float), (True, bool), ("#.", str)]


def test_newlines_carry_no_meaning() -> None:
    words = "model M reward r = a + b terminal when c"
    assert shape(model(words)) == shape(model(words.replace(" ", "\n\t")))


def test_spans_are_exact() -> None:
    tree = expression("(a + b) *\n  f(c)'")
    assert isinstance(tree, ast.Binary)
    assert tree.span == Span("e", 1, 1, 2, 8)
    assert tree.left.span == Span("e", 1, 2, 1, 7)  # without its parentheses
    assert tree.right.span == Span("e", 2, 3, 2, 8)
    assert isinstance(tree.right, ast.Prime)
    assert tree.right.operand.span == Span("e", 2, 3, 2, 7)


def test_spans_of_declarations() -> None:
    file = model("model M\nelement e {\n  visible a, b: bool\n  hidden c: bool\n  c' = a\n}\n")
    element = file.items[0]
    assert isinstance(element, ast.Element)
    assert element.span == Span("m", 2, 1, 6, 2)
    places = [(m.span.line, m.span.column, m.span.end_column) for m in element.members]
    assert places == [(3, 11, 12), (3, 14, 15), (4, 3, 17), (5, 3, 9)]
    update = element.members[3]
    assert isinstance(update, ast.Update)
    assert (update.rhs.span.column, update.rhs.expr.span.column) == (6, 8)


def test_instance_keeps_order_and_the_place_of_its_model() -> None:
    file = parse(Source("i", 'instance small of "m.pomdp" {\n  n = 3  k = [1, 2]\n}'))
    assert isinstance(file, ast.InstanceFile)
    assert (file.name, file.model, file.model_span) == ("small", "m.pomdp", Span("i", 1, 19, 1, 28))
    assert [(a.name, shape(a.value)) for a in file.assignments] == [("n", 3), ("k", ("ArrayLiteral", (1, 2)))]


def test_a_trailing_text_is_no_expression() -> None:
    with pytest.raises(ModelError):
        expression("3 4")
