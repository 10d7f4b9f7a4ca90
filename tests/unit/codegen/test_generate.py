# SPDX-License-Identifier: Apache-2.0
"""Code generation part by part: names, literals, expressions, tables, guards."""

from __future__ import annotations

import dataclasses
import re
import struct
from pathlib import Path

import pytest
from support import ir_samples
from support.ir_samples import ROCK, both, const, equal
from support.paths import EXAMPLES

from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.cpp.sink import RETURN
from hypgen.codegen.cpp.text import float32, literal
from hypgen.codegen.generate import generate
from hypgen.codegen.layout.naming import Names, Scope, file_stem, snake_case
from hypgen.codegen.layout.state_layout import pack
from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.guards import Guards
from hypgen.codegen.passes.state_tables import state_reads
from hypgen.codegen.passes.tabulate import tabulate
from hypgen.codegen.project import context_of
from hypgen.codegen.tree.lines import statements, text_of
from hypgen.dsl import ir
from hypgen.dsl.load import load
from hypgen.dsl.types import BOOL, FLOAT, INT, Enum, Int, Record, Type, Variant, size_of

SAMPLES = (ir_samples.tiger, ir_samples.rocks, ir_samples.wanderer)

A, B, C = (ir.Local(Int(0, 9), name) for name in "abc")
X, Y, Z = (ir.Local(FLOAT, name) for name in "xyz")
P, Q = (ir.Local(BOOL, name) for name in "pq")


def printed(expr: ir.Expr, model: ir.Model | None = None) -> str:
    model = model or ir_samples.rocks()
    builder = Builder(context_of(model, (), Names(model)))
    for local in (A, B, C, X, Y, Z, P, Q):
        builder.local(local.name, local.type)
    builder.local("r", ROCK)
    builder.printer.emit(expr, RETURN)
    return "\n".join(statements(builder.code.body))


def binary(op: str, left: ir.Expr, right: ir.Expr) -> ir.Binary:
    kind = BOOL if op in ("and", "or", "eq", "lt") else left.type
    return ir.Binary(kind, op, left, right)


# Names -------------------------------------------------------------------------------------------


def test_names_stay_as_they_are_unless_something_has_them() -> None:
    scope = Scope()
    assert [scope.unique(n) for n in ("rover.x", "rover_x", "class", "step", "x", "x")] == [
        "rover_x",
        "rover_x_2",
        "class_",
        "step_",
        "x",
        "x_2",
    ]


@pytest.mark.parametrize(
    ("name", "expected"),
    [("RockSample", "rock_sample"), ("POMDPModel", "pomdp_model"), ("T2", "t2"), ("Nav_A", "nav_a")],
)
def test_snake_case(name: str, expected: str) -> None:
    assert snake_case(name) == expected


def test_an_executable_is_not_called_like_a_build_folder() -> None:
    assert file_stem(dataclasses.replace(ir_samples.tiger(), name="Hypgen")) == "hypgen_model"


# Literals ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.0, "1.0f"), (-0.0, "-0.0f"), (0.949999988079071, "0.95f"), (1e30, "1e+30f"), (float("inf"), None)],
)
def test_floats_are_short(value: float, text: str | None) -> None:
    rounded = struct.unpack("<f", struct.pack("<f", value))[0]
    assert float32(rounded) == (text or "std::numeric_limits<float>::infinity()")


def test_floats_are_exact() -> None:
    for bits in [1, 0x007FFFFF, 0x00800000, 0x7F7FFFFF, *range(0x3F000000, 0x3F800000, 99991)]:
        value = struct.unpack("<f", struct.pack("<I", bits))[0]
        text = float32(value).removesuffix("f")
        back = float.fromhex(text) if "x" in text else float(text)
        assert struct.pack("<f", back) == struct.pack("<f", value), text


def test_codes_are_written_as_in_the_model() -> None:
    inner = Enum("Inner", (Variant("on"), Variant("level", Int(2, 4))))
    pair = Record("Pair", (("flag", BOOL), ("inner", inner)))
    model = dataclasses.replace(ir_samples.tiger(), enums=(inner,), records=(pair,))
    names = Names(model)
    assert text_of(literal(0, inner, names)) == "Inner::on"
    assert text_of(literal(3, inner, names)) == "Inner::level(4)"
    assert text_of(literal(6, pair, names)) == "Pair::make(true, Inner::level(3))"
    assert text_of(literal(-(2**31), INT, names)) == "(-2147483647 - 1)"


# Expressions -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (binary("sub", A, binary("sub", B, C)), "a - (b - c)"),
        (binary("sub", binary("sub", A, B), C), "a - b - c"),
        (binary("mul", binary("add", A, B), C), "(a + b) * c"),
        (binary("add", X, binary("add", Y, Z)), "x + (y + z)"),
        (binary("or", both(P, Q), P), "(p && q) || p"),
        (both(P, binary("or", P, Q)), "p && (p || q)"),
        (ir.Unary(BOOL, "not", equal(A, B)), "a != b"),
        (equal(ir.Unary(BOOL, "not", P), Q), "(!p) == q"),
        (ir.Unary(Int(-9, 9), "neg", const(-3)), "-(-3)"),
        (binary("sub", A, const(-3)), "a - -3"),
        (ir.Clamp(Int(0, 5), A, 0, 5), "math::min(a, 5)"),
        (ir.Clamp(Int(-5, 5), ir.Local(INT, "a"), -5, 5), "math::clamp(a, -5, 5)"),
        (binary("floordiv", A, const(3)), "a / 3"),
        (binary("floordiv", A, B), "math::floordiv(a, b)"),
        (binary("mod", ir.Local(INT, "a"), const(3)), "math::mod(a, 3)"),
        (ir.Unary(Int(0, 4), "round", X), "math::round_to_int(x, 0, 4)"),
        (ir.ToFloat(FLOAT, const(3)), "3.0f"),
        (ir.If(Int(0, 9), P, A, B), "p ? a : b"),
        (ir.Call(BOOL, "here", (ir.Local(ROCK, "r"),)), "here(params, state, r)"),
        (ir.Call(BOOL, "here", (ir.Local(ROCK, "r"),), True), "here(params, next, r)"),
    ],
)
def test_expression(expr: ir.Expr, text: str) -> None:
    assert printed(expr) == f"return {text};"


def test_not_of_a_variant_test_leaves_its_operand_as_it_is() -> None:
    door = ir_samples.DOOR
    left, right = (ir.Const(door, code) for code in (0, 1))
    chosen = ir.If(door, equal(A, const(3)), left, right)
    is_left = ir.IsVariant(BOOL, door, "left", chosen)
    text = "(a == 3 ? Door::left : Door::right) {} Door::left"
    model = ir_samples.tiger()
    assert printed(is_left, model) == f"return {text.format('==')};"
    assert printed(ir.Unary(BOOL, "not", is_left), model) == f"return {text.format('!=')};"


def test_what_a_condition_guards_is_computed_behind_it() -> None:
    loop = ir.Quantified(
        BOOL, "any", (ir.Binder("i", Int(0, 3)),), None, equal(ir.Local(Int(0, 3), "i"), A), None
    )
    assert printed(both(P, loop)).split("\n") == [
        "bool holds = p;",
        "if (holds) {",
        "  bool found = false;",
        "  for (std::int32_t i = 0; i <= 3; ++i) found |= i == a;",
        "  holds = found;",
        "}",
        "return holds;",
    ]


def test_siblings_may_introduce_the_same_name() -> None:
    def squared(of: ir.Expr) -> ir.Expr:
        k = ir.Local(Int(0, 9), "k")
        return ir.LetIn(Int(0, 81), "k", of, binary("mul", k, k))

    assert printed(binary("add", squared(A), squared(B))).split("\n") == [
        "const std::int32_t k = a;",
        "const std::int32_t k_2 = b;",
        "return k * k + k_2 * k_2;",
    ]


# Tables ------------------------------------------------------------------------------------------


def test_slow_formulas_of_finite_inputs_become_tables() -> None:
    model = ir_samples.rocks()
    tabulated, tables = tabulate(model, Names(model))
    assert [(t.name, [b.name for b in t.inputs]) for t in tables] == [
        ("accuracy_table", ["rover_x", "r"]),
        ("upper_table", ["rover_x"]),
    ]
    assert not _slow(tabulated.upper)
    body = next(f.body for f in tabulated.functions if f.name == "accuracy")
    assert isinstance(body, ir.ParamRead)
    # Its callers have nothing left to tabulate.
    assert tabulated.observations == model.observations


def test_a_wide_range_is_narrowed_to_a_finite_part() -> None:
    model = ir_samples.rocks()
    wide = ir.Local(Int(0, 10**6), "r")
    part = ir.Binary(Int(0, 9), "mod", wide, const(10))
    power = ir.Binary(FLOAT, "pow", const(0.5), ir.ToFloat(FLOAT, part))
    function = ir.Function("decay", (ir.Binder("r", wide.type),), FLOAT, power, ir_samples.span(3))
    tabulated, tables = tabulate(
        dataclasses.replace(model, functions=(*model.functions, function)), Names(model)
    )
    found = next(t for t in tables if t.name == "decay_table")
    assert [b.type for b in found.inputs] == [Int(0, 9)]
    read = next(f.body for f in tabulated.functions if f.name == "decay")
    assert isinstance(read, ir.ParamRead)
    assert read.indices == (part,)


def test_finite_values_and_draws_become_byte_tables() -> None:
    header = generate(load(EXAMPLES / "tag.pomdp").model)["src/tag.hpp"]
    assert "std::uint8_t opponent_cell_table[50][50][5];" in header
    assert "dist::reached(word, 0x33333340u)" in header
    assert "static_cast<std::uint8_t>(compute_back_table(d))" in header


def test_a_bound_over_a_family_is_one_load(tmp_path: Path) -> None:
    walk = "min(q in Rock where rock[q].good: max(walk_to(q), walk_to(r)) else 0)"
    bound = f"bound upper = 10 + sum(r in Rock where rock[r].good: 10 * gamma ** {walk})\n"
    path = tmp_path / "rocks.pomdp"
    path.write_text((EXAMPLES / "rock_sample.pomdp").read_text() + bound)
    model = load(path).model
    tabulated, tables = tabulate(model, Names(model))
    table = next(t for t in tables if t.name == "upper_state_table")
    assert table.variables == ("rover.x", "rover.y", "rock.good")
    assert [b.type for b in table.inputs] == [Int(0, 7), Int(0, 6), Int(0, 255)]
    assert isinstance(tabulated.upper, ir.ParamRead)
    # Filled after the tables that its formula reads.
    assert table is tables[-1]


@pytest.mark.parametrize(
    ("type_", "count", "primed", "indexed"),
    [
        (BOOL, 12, False, True),
        (Int(0, 3), 6, False, True),
        (Int(0, 2), 6, False, False),  # a pattern of bits may be no value
        (BOOL, 33, False, False),  # no one word
        (BOOL, 20, False, False),  # too many patterns
        (BOOL, 12, True, False),  # another state than the table's
    ],
)
def test_an_array_is_an_index_where_every_pattern_is_a_state(
    type_: Type, count: int, primed: bool, indexed: bool
) -> None:
    member = ir.Binder("i", Int(0, count - 1))
    variable = ir.Variable("e.a", "e", type_, (member.type,), False, False, ir_samples.span(1))
    fields = {
        f.variable: f
        for f in pack(dataclasses.replace(ir_samples.tiger(), variables=(variable,))).state.fields
    }
    read = ir.StateRead(type_, "e.a", (ir.Local(member.type, "i"),), primed)
    value = ir.Quantified(Int(0, count), "count", (member,), read, None, None)
    reads = state_reads(value, fields)
    assert (reads is not None) == indexed
    if reads is not None:
        assert [size_of(r.type) for r in reads] == [size_of(type_) ** count]


def test_a_formula_of_a_float_is_computed() -> None:
    model = ir_samples.rocks()
    root = ir.Function(
        "root", (ir.Binder("x", FLOAT),), FLOAT, ir.Unary(FLOAT, "sqrt", X), ir_samples.span(3)
    )
    tabulated, _ = tabulate(dataclasses.replace(model, functions=(*model.functions, root)), Names(model))
    assert tabulated.functions[-1] == root


def _slow(node: ir.Expr) -> bool:
    from hypgen.dsl.ir.walk import walk

    return any(isinstance(n, ir.Binary) and n.op == "pow" for n in walk(node))


# Guards ------------------------------------------------------------------------------------------


def test_a_family_is_visited_only_where_something_can_change() -> None:
    model = ir_samples.rocks()
    guards = Guards(model, NeedsAnalysis(model))
    sampling = equal(ir.ActionRead(ir_samples.ROCK_ACT), ir_samples.variant(ir_samples.ROCK_ACT, "sample"))
    assert guards.update((model.updates[1],)) == sampling
    assert guards.reward(model.rewards[1]) == sampling


def test_without_a_common_condition_there_is_no_guard() -> None:
    model = ir_samples.wanderer()
    guards = Guards(model, NeedsAnalysis(model))
    assert guards.reward(model.rewards[0]) is None
    assert guards.update((model.updates[1],)) is None


# The whole ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda f: f.__name__)
def test_generated_text_is_tidy(sample: object) -> None:
    assert callable(sample)
    for path, text in generate(sample()).items():
        assert text.endswith("\n") and not text.endswith("\n\n"), path
        for line in text.splitlines():
            assert line == line.rstrip(), f"{path}: {line!r}"
            assert len(line) <= 120, f"{path}: {line}"
        assert not re.search(r"/(tmp|home|work|usr)/", text), path


def test_functions_carry_the_line_that_they_come_from() -> None:
    text = generate(ir_samples.rocks())["src/small_rocks.hpp"]
    assert "// sample.pomdp:8\n  HYPGEN_FN static bool here(" in text


def test_the_descriptor_lists_hidden_variables() -> None:
    def listed(example: str) -> str:
        text = generate(load(EXAMPLES / example).model)["src/library.cpp"]
        return "".join(re.findall(r"hidden_variables = (.*);", text))

    assert listed("light_dark.pomdp") == '{{"robot.at.x", 0, 1, true}, {"robot.at.y", 1, 1, true}}'
    assert listed("rock_sample.pomdp") == '{{"rock.good", 2, 8, false}}'


def test_the_descriptor_lists_what_may_be_no_number(tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_text("""model M
action act: bool
discount 0.9
param p: float = 2
element room { hidden x: 0 .. 3  init x ~ uniform(0, 3)  x' = x }
observe seen: bool ~ noisy(room.x' > 1, 0.9)
reward safe = room.x
reward root = if act then sqrt(room.x - 1) else 0
bound upper = 40 / p
bound tail = 0
""")
    text = generate(load(path).model)["src/library.cpp"]
    assert """doubtful = {"bound upper (m.pomdp:9)", "reward 'root' (m.pomdp:8)"};""" in text
    assert "doubtful" not in generate(load(EXAMPLES / "tiger.pomdp").model)["src/library.cpp"]
