# SPDX-License-Identifier: Apache-2.0
"""Constants: folding, closures, early decisions and the interpreter agree on every operator, at its edges."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import product
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.interpreted import value as interpreted

from hypgen.dsl import ir
from hypgen.dsl.check.constants.closures import Closures, Irregular
from hypgen.dsl.ir import evaluate, operators
from hypgen.dsl.ir import trigonometric_operators as trigonometric
from hypgen.dsl.ir.walk import substitute
from hypgen.dsl.types import (
    BOOL,
    FLOAT,
    INT,
    INT32_MAX,
    INT32_MIN,
    Bool,
    Enum,
    Float,
    Int,
    Record,
    Type,
    Variant,
)

Value = bool | int | float
Build = Callable[..., ir.Expr]

_LARGEST = 3.4028234663852886e38
FLOATS = [
    *(sign * x for sign in (1, -1) for x in (0.0, 2.0**-149, 0.5, 1.0, 1.5, 2.5, 2.0**24, 2.0**31, _LARGEST)),
    *(evaluate.single(x) for x in (0.1, -0.3, math.pi, 88.0, 1e-20)),
]
INTS = [INT32_MIN, -(2**24) - 1, -7, -2, -1, 0, 1, 2, 3, 7, 2**24 + 1, INT32_MAX]

ARITHMETIC = ("add", "sub", "mul", "min", "max")
COMPARED = tuple(evaluate.COMPARISONS)
OF_TWO: dict[str, Build] = {
    **{op: partial(operators.arithmetic, op) for op in (*ARITHMETIC, "div", "floordiv", "mod")},
    **{op: partial(operators.compare, op) for op in COMPARED},
    "pow": operators.power,
    "hypot": operators.hypotenuse,
    "atan2": trigonometric.arc_of_point,
}
OF_ONE: dict[str, Build] = {
    "neg": operators.negate,
    "abs": operators.absolute,
    "sign": operators.sign,
    "normal_cdf": operators.normal_cdf,
    **{op: partial(operators.rising, op) for op in ("sqrt", "exp", "log", "log2")},
    **{op: partial(operators.to_int, op) for op in evaluate.ROUNDINGS},
    **{op: partial(trigonometric.periodic, op) for op in trigonometric.PERIODIC},
    **{op: partial(trigonometric.arc, op) for op in trigonometric.ARCS},
}


def cases() -> Iterator[tuple[str, Build, Type, int]]:
    """Yield every operator with what folds it, its operands' type and their number."""
    for op, build in OF_TWO.items():
        if op in (*ARITHMETIC, *COMPARED, "floordiv", "mod"):
            yield op, build, INT, 2
        if op not in ("floordiv", "mod"):
            yield op, build, FLOAT, 2
    for op, build in OF_ONE.items():
        if op in ("neg", "abs", "sign"):
            yield op, build, INT, 1
        yield op, build, FLOAT, 1


def node_of(op: str, t: Type, operands: int) -> ir.Expr:
    """Return the operator on the locals ``a`` and ``b`` of the type."""
    result = BOOL if op in COMPARED else INT if op in evaluate.ROUNDINGS else t
    a, b = ir.Local(t, "a"), ir.Local(t, "b")
    return ir.Unary(result, op, a) if operands == 1 else ir.Binary(result, op, a, b)


def constant(t: Type, value: Value) -> ir.Const:
    return operators.real(value) if isinstance(t, Float) else operators.constant(t, value)


def shown(value: Value | None) -> str:
    """Return what tells values apart, signs of zeros and kinds included."""
    return repr(value)


def by_closure(node: ir.Expr, values: dict[str, Any]) -> Value | None:
    try:
        found: Value = Closures(cast(Any, None)).code(node)(values)
    except (Irregular, ArithmeticError, ValueError):
        return None
    return found


def reading(values: Mapping[str, Value]) -> evaluate.Known:
    return lambda e: values[e.name] if isinstance(e, ir.Local) else None


CASES = [pytest.param(*case, id=f"{case[0]}-{case[2]}") for case in cases()]


def test_all_operators_are_tried() -> None:
    assert {op for op, *_ in cases()} | {"not"} == set(evaluate.OPERATORS)


@pytest.mark.parametrize(("op", "build", "t", "operands"), CASES)
def test_all_who_compute_constants_agree(op: str, build: Build, t: Type, operands: int) -> None:
    node = node_of(op, t, operands)
    for given_ in product(FLOATS if isinstance(t, Float) else INTS, repeat=operands):
        values: dict[str, Value] = dict(zip("ab", given_, strict=False))
        folded = build(*(constant(t, v) for v in given_))
        want = folded.value if isinstance(folded, ir.Const) else None
        decided = evaluate.decided(node, reading(values))
        if op in evaluate.INEXACT:
            assert decided is None
        else:
            assert shown(decided) == shown(want), given_
        if op in ("floordiv", "mod") and given_[1] == 0:
            assert (want, by_closure(node, values)) == (0, None)  # the checker refuses it
        else:
            assert shown(by_closure(node, values)) == shown(want), given_


@pytest.mark.parametrize(("op", "build", "t", "operands"), CASES)
def test_the_interpreter_computes_the_same(op: str, build: Build, t: Type, operands: int) -> None:
    edges = FLOATS if isinstance(t, Float) else INTS
    node = node_of(op, t, operands)
    for right in edges if operands == 2 else (None,):
        values: dict[str, ir.Expr] = {"a": ir.Local(t, "v")}
        if right is not None:
            values["b"] = constant(t, right)
        given_ = [(left,) if right is None else (left, right) for left in edges]
        with np.errstate(all="ignore"):
            lanes = interpreted(substitute(node, values), edges)
        for operands_, lane in zip(given_, lanes, strict=True):
            want = evaluate.value_of(op, node.type, *operands_)
            if want is None or isinstance(node.type, Int) and not INT32_MIN <= want <= INT32_MAX:
                continue
            if op in evaluate.INEXACT:
                assert lane == pytest.approx(want, rel=2e-6, abs=1e-6), operands_
            else:
                assert shown(lane) == shown(want), operands_


# Values of enums and records ---------------------------------------------------------------------

INNER = Enum("Inner", (Variant("on"), Variant("level", Int(2, 4)), Variant("lit", BOOL)))
PAIR = Record("Pair", (("flag", BOOL), ("inner", INNER), ("row", Int(-1, 1))))


@given(st.integers(0, 5))
def test_variants_are_taken_apart_alike(code: int) -> None:
    whole, local = ir.Const(INNER, code), ir.Local(INNER, "a")
    for name in ("on", "level", "lit"):
        agree(operators.is_variant(INNER, name, whole), ir.IsVariant(BOOL, INNER, name, local), {"a": code})
        variant = INNER.variant(name)
        assert variant is not None
        if variant.argument is None or not operators.is_true(operators.is_variant(INNER, name, whole)):
            continue
        argument = ir.VariantArgument(variant.argument, INNER, name, local)
        found = operators.variant_argument(INNER, name, whole)
        agree(found, argument, {"a": code})
        assert operators.make_variant(INNER, name, found) == whole
        agree(whole, ir.MakeVariant(INNER, INNER, name, argument), {"a": code})


@given(st.booleans(), st.integers(0, 5), st.integers(-1, 1))
def test_records_are_put_together_alike(flag: bool, inner: int, row: int) -> None:
    parts = (constant(BOOL, flag), constant(INNER, inner), constant(Int(-1, 1), row))
    whole = operators.make_record(PAIR, parts)
    locals_ = tuple(ir.Local(t, name) for name, t in PAIR.fields)
    made = ir.MakeRecord(PAIR, PAIR, locals_)
    values: dict[str, Value] = {"flag": flag, "inner": inner, "row": row}
    agree(whole, made, values)
    for (name, t), part in zip(PAIR.fields, parts, strict=True):
        assert operators.field(PAIR, name, whole) == part
        agree(part, ir.FieldRead(t, PAIR, name, made), values)


def agree(folded: ir.Expr, node: ir.Expr, values: dict[str, Value]) -> None:
    assert isinstance(folded, ir.Const)
    decided = evaluate.decided(node, reading(values))
    assert decided == by_closure(node, values) == folded.value
    assert isinstance(decided, bool) == isinstance(folded.type, Bool)


# What is known in part ---------------------------------------------------------------------------


def test_one_side_may_decide() -> None:
    p, q = ir.Local(BOOL, "p"), ir.Local(BOOL, "q")
    known = {"p": True}
    for op, want in (("or", True), ("and", None)):
        for a, b in ((p, q), (q, p)):
            found = evaluate.decided(ir.Binary(BOOL, op, a, b), lambda e: known.get(cast(ir.Local, e).name))
            assert found is want
    same = ir.If(INT, q, ir.Const(INT, 3), ir.Const(INT, 3))
    assert evaluate.decided(same, lambda _: None) == 3
