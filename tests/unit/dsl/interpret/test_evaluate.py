# SPDX-License-Identifier: Apache-2.0
"""Expressions and distributions by themselves, evaluated inside a model that has nothing but a name."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from support import ir_samples
from support.interpreted import evaluator, value

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.types import (
    BOOL,
    FLOAT,
    INT,
    PROB,
    Bool,
    Enum,
    Int,
    Record,
    Type,
    Variant,
    low_of,
    size_of,
)

LANES = 2**16
WORDS = np.arange(LANES, dtype=np.uint64) << np.uint64(16)  # evenly over all words
COL = Int(-1, 3)
ACT = Enum("Act", (Variant("wait"), Variant("check", COL), Variant("stop")))
POS = Record("Pos", (("row", Int(2, 4)), ("col", COL), ("lit", BOOL)))


def const(value: bool | int | float, t: Type | None = None) -> ir.Const:
    return ir_samples.const(value, t)


def local(t: Type, name: str = "v") -> ir.Local:
    return ir.Local(t, name)


def binary(op: str, t: Type, left: ir.Expr, right: ir.Expr) -> ir.Binary:
    return ir.Binary(t, op, left, right)


@pytest.mark.parametrize(
    ("op", "lanes", "right", "want"),
    [
        ("add", [1, -2], 3, [4, 1]),
        ("sub", [1, -2], 3, [-2, -5]),
        ("mul", [1, -2], 3, [3, -6]),
        ("floordiv", [7, -7], 2, [3, -4]),
        ("floordiv", [7, -7], 0, [0, 0]),
        ("mod", [7, -7], 3, [1, 2]),
        ("min", [7, -7], 3, [3, -7]),
        ("max", [7, -7], 3, [7, 3]),
    ],
)
def test_integer_operators(op: str, lanes: list[int], right: int, want: list[int]) -> None:
    assert value(binary(op, INT, local(INT), const(right)), lanes) == want


def test_float_arithmetic_is_single_precision() -> None:
    x = local(FLOAT)
    third = np.float32(1) / np.float32(3)
    assert value(binary("div", FLOAT, x, const(3.0)), [1.0]) == [third]
    assert value(binary("mul", FLOAT, x, const(0.10000000149011612)), [0.3]) == [
        np.float32(0.3) * np.float32(0.1)
    ]
    assert value(ir.ToFloat(FLOAT, local(INT)), [2**24 + 1]) == [2.0**24]
    assert value(ir.Unary(Int(-2, 2), "round", x), [0.5, 1.5, 9.0, float("nan")]) == [0, 2, 2, -2]


def test_clamp_keeps_nan_and_forces_everything_else() -> None:
    assert value(ir.Clamp(COL, local(INT), -1, 3), [-9, 2, 9]) == [-1, 2, 3]
    low, middle, nan = value(ir.Clamp(FLOAT, local(FLOAT), 0.0, 1.0), [-3.0, 0.5, float("nan")])
    assert (low, middle) == (0.0, 0.5) and np.isnan(nan)


def test_conditionals_choose_by_lane() -> None:
    positive = binary("gt", BOOL, local(INT), const(0))
    assert value(ir.If(INT, positive, local(INT), const(-1)), [-5, 5]) == [-1, 5]
    assert value(ir.LetIn(INT, "w", local(INT), binary("add", INT, ir.Local(INT, "w"), local(INT))), [4]) == [
        8
    ]


def test_variants_with_arguments_are_coded_from_their_low_value() -> None:
    codes = [0, 1, 5, 6]  # wait, check(-1), check(3), stop
    assert value(ir.IsVariant(BOOL, ACT, "check", local(ACT)), codes) == [False, True, True, False]
    assert value(ir.IsVariant(BOOL, ACT, "stop", local(ACT)), codes) == [False, False, False, True]
    assert value(ir.VariantArgument(COL, ACT, "check", local(ACT)), codes)[1:3] == [-1, 3]
    assert value(ir.MakeVariant(ACT, ACT, "check", local(COL)), [-1, 3]) == [1, 5]


def test_records_are_lexicographic_codes() -> None:
    made = ir.MakeRecord(POS, POS, (const(3), local(COL), const(True)))
    assert value(made, [-1, 3]) == [11, 19]
    for name, want in (("row", [3, 3]), ("col", [-1, 3]), ("lit", [True, True])):
        t = POS.field_type(name)
        assert t is not None
        assert value(ir.FieldRead(t, POS, name, local(POS)), [11, 19]) == want


def quantified(kind: str, t: Type, condition: ir.Expr | None, body: ir.Expr | None, **rest: Any) -> ir.Expr:
    return ir.Quantified(t, kind, (ir.Binder("c", COL),), condition, body, rest.get("otherwise"))


def test_quantifiers() -> None:
    c, v = ir.Local(COL, "c"), local(INT)
    above = binary("gt", BOOL, c, v)
    square = binary("mul", INT, c, c)
    lanes = [-9, 0, 2, 3]
    assert value(quantified("sum", INT, above, c), lanes) == [5, 6, 3, 0]
    assert value(quantified("count", INT, above, None), lanes) == [5, 3, 1, 0]
    assert value(quantified("any", BOOL, above, binary("eq", BOOL, c, const(0))), lanes) == [
        True,
        False,
        False,
        False,
    ]
    assert value(quantified("all", BOOL, above, binary("gt", BOOL, c, const(1))), lanes) == [
        False,
        False,
        True,
        True,
    ]
    assert value(quantified("min", INT, above, square, otherwise=const(-7)), lanes) == [0, 1, 9, -7]
    assert value(quantified("max", INT, above, square), lanes) == [9, 9, 9, 1]  # the first value stands in
    assert value(quantified("argmin", COL, above, square, otherwise=const(-1, COL)), lanes) == [0, 1, 3, -1]
    first = binary("mod", INT, square, const(1))
    assert value(quantified("argmax", COL, above, first), lanes) == [-1, 1, 3, -1]  # all equal: the first


def test_tables_are_indexed_from_the_low_of_their_types() -> None:
    table = ir.ConstantArray("cost", INT, (COL, BOOL), tuple(range(10)), ir_samples.span(1))
    read = ir.TableRead(INT, "cost", (local(COL), const(True)))
    assert value(read, [-1, 0, 3], evaluator(tables=(table,))) == [1, 3, 9]


def draws_and_densities(dist: ir.Dist, v: Any = 0) -> tuple[Array, dict[Any, float]]:
    evaluate = evaluator()
    frame = Frame(np.arange(LANES), {}, locals={"v": np.int32(v)})
    drawn = np.broadcast_to(evaluate.sample(dist, frame, ir_samples.word(WORDS)), (LANES,))
    candidates = (
        [False, True]
        if isinstance(dist.type, Bool)
        else range(low_of(dist.type), low_of(dist.type) + size_of(dist.type))
    )
    return drawn, {x: float(np.max(evaluate.density(dist, frame, np.asarray(x)))) for x in candidates}


def table(*entries: tuple[int, float], rest: int | None = None) -> ir.Table:
    pairs = tuple((const(x), const(p)) for x, p in entries)
    return ir.Table(COL, pairs, None if rest is None else const(rest))


EVEN = binary("eq", BOOL, binary("mod", Int(0, 1), ir.Local(COL, "c"), const(2)), const(0))
NOTHING = const(False)


def uniform_set(condition: ir.Expr | None, otherwise: ir.Dist | None = None) -> ir.UniformSet:
    return ir.UniformSet(COL, (ir.Binder("c", COL),), condition, ir.Local(COL, "c"), otherwise)


@pytest.mark.parametrize(
    ("dist", "want"),
    [
        (ir.Certain(COL, local(COL)), {0: 1.0}),
        (ir.Bernoulli(BOOL, const(0.25)), {True: 0.25, False: 0.75}),
        (ir.Bernoulli(BOOL, const(1.5)), {True: 1.0}),
        (ir.Uniform(Int(1, 4)), {1: 0.25, 2: 0.25, 3: 0.25, 4: 0.25}),
        (ir.Noisy(COL, const(1), const(0.5)), {-1: 0.125, 0: 0.125, 1: 0.5, 2: 0.125, 3: 0.125}),
        (ir.Noisy(COL, const(1), const(1.0)), {1: 1.0}),
        (ir.Noisy(Int(1, 1), const(1), const(0.5)), {1: 1.0}),
        (table((3, 0.25), (0, 0.5), rest=1), {3: 0.25, 0: 0.5, 1: 0.25}),
        (table((3, 0.25), (0, 0.5)), {3: 0.25, 0: 0.75}),
        (table((3, 0.25), (0, 0.25), (3, 0.25), rest=0), {3: 0.5, 0: 0.5}),
        (table((3, 0.75), (0, 0.75), (1, 0.5), rest=2), {3: 0.75, 0: 0.25}),
        (uniform_set(EVEN), {0: 0.5, 2: 0.5}),
        (uniform_set(NOTHING), {-1: 1.0}),
        (uniform_set(NOTHING, ir.Uniform(COL)), dict.fromkeys(range(-1, 4), 0.2)),
        (ir.IfDist(COL, const(False), ir.Uniform(COL), ir.Certain(COL, const(2))), {2: 1.0}),
        (ir.LetDist(COL, "w", const(2), ir.Certain(COL, ir.Local(COL, "w"))), {2: 1.0}),
    ],
)
def test_samplers_and_densities_agree(dist: ir.Dist, want: dict[Any, float]) -> None:
    drawn, densities = draws_and_densities(dist)
    for x, density in densities.items():
        assert density == pytest.approx(want.get(x, 0.0), abs=1e-12)
        assert np.count_nonzero(drawn == x) / LANES == pytest.approx(density, abs=2**-15)


def test_a_set_whose_condition_differs_by_lane() -> None:
    above = binary("gt", BOOL, ir.Local(COL, "c"), local(INT))
    lanes = np.array([-1, 1, 2, 3], dtype=np.int32)
    frame = Frame(np.arange(4), {}, locals={"v": lanes})
    last = np.full(4, 2**32 - 1, dtype=np.uint64)
    first = np.zeros(4, dtype=np.uint64)
    evaluate = evaluator()
    assert evaluate.sample(uniform_set(above), frame, ir_samples.word(first)).tolist() == [0, 2, 3, -1]
    assert evaluate.sample(uniform_set(above), frame, ir_samples.word(last)).tolist() == [3, 3, 3, -1]
    assert evaluate.density(uniform_set(above), frame, np.int32(3)).tolist() == [0.25, 0.5, 1.0, 0.0]


def test_a_param_of_the_wrong_length_or_without_a_value_is_refused() -> None:
    param = ir.Param("p", PROB, (COL,), None, ir_samples.span(1))
    with pytest.raises(ValueError, match="no default"):
        evaluator(params=(param,))
    with pytest.raises(ValueError, match="takes 5 values, not 2"):
        evaluator(params=(dataclasses.replace(param, default=(0.5, 0.5)),))
