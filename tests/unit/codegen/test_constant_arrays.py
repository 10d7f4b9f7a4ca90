# SPDX-License-Identifier: Apache-2.0
"""Constant arrays in C++: small ones as lists, large ones as strings of their bits."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support import ir_samples

from hypgen.codegen.cpp.constant_arrays import constant_array
from hypgen.codegen.cpp.function_builder import laid_out
from hypgen.codegen.cpp.template_data import Function
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.project import context_of
from hypgen.dsl import ir
from hypgen.dsl.types import BOOL, FLOAT, Int, Type

SIZE = 80


def printed(type_: Type, values: list[float] | list[int] | list[bool], *sizes: int) -> Function:
    span = ir_samples.rocks().variables[0].span
    table = ir.ConstantArray("worth", type_, tuple(Int(0, s - 1) for s in sizes), tuple(values), span)
    model = ir_samples.rocks()
    context = context_of(model, (), Names(model))
    context.names.tables["worth"] = "worth"
    return laid_out(constant_array(table, context))


def words(function: Function) -> list[int]:
    return [int(word, 16) for word in re.findall(r"\\x([0-9a-f]+)", "\n".join(function.body))]


def test_a_small_array_is_a_list() -> None:
    function = printed(FLOAT, [0.5, -1.0, 3.0, 0.1], 2, 2)
    assert function.body == (
        "static constexpr float values[2][2] = {{0.5f, -1.0f}, {3.0f, 0.1f}};",
        "return values[i0][i1];",
    )


def test_a_large_array_of_floats_is_a_string_of_their_bits() -> None:
    values = [float(v) for v in np.random.default_rng(3).normal(size=SIZE * SIZE).astype(np.float32)]
    values[:3] = [0.0, -0.0, -1.5]
    function = printed(FLOAT, values, SIZE, SIZE)
    assert function.body[:3] == (
        "const std::int32_t entry = i0 * 80 + i1;",
        "static constexpr char32_t bits[] =",
        '    U"' + "".join(f"\\x{w:x}" for w in np.float32(values[:8]).view(np.uint32)) + '"',
    )
    assert function.body[-1] == "return math::from_bits(static_cast<std::uint32_t>(bits[entry]));"
    assert words(function) == np.float32(values).view(np.uint32).tolist()


@pytest.mark.parametrize(
    ("type_", "result"), [(BOOL, "bits[entry] != 0"), (Int(-9, 9), "static_cast<std::int32_t>(bits[entry])")]
)
def test_other_large_arrays_are_strings_too(type_: Type, result: str) -> None:
    values = [n % 2 if type_ is BOOL else n % 19 - 9 for n in range(2 * SIZE * SIZE)]
    function = printed(type_, values, 2, SIZE, SIZE)
    assert function.body[0] == "const std::int32_t entry = (i0 * 80 + i1) * 80 + i2;"
    assert function.body[-1] == f"return {result};"
    assert np.uint32(words(function)).view(np.int32).tolist() == values
