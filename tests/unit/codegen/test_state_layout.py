# SPDX-License-Identifier: Apache-2.0
"""Packing: fields lie where they say, cross no word and share no word with another element."""

from __future__ import annotations

import dataclasses

import pytest
from support import ir_samples

from hypgen.codegen.layout.state_layout import Block, Field, pack
from hypgen.dsl import ir
from hypgen.dsl.types import BOOL, FLOAT, INT32_MAX, INT32_MIN, Int, Type

MODELS = [ir_samples.tiger(), ir_samples.rocks(), ir_samples.wanderer()]


def variable(name: str, type_: Type, *indices: Type, fixed: bool = False) -> ir.Variable:
    return ir.Variable(name, name.split(".")[0], type_, indices, False, fixed, ir_samples.span(1))


def packed(*variables: ir.Variable) -> Block:
    model = dataclasses.replace(ir_samples.tiger(), variables=variables)
    return pack(model).state


def bits(field: Field) -> set[int]:
    start = field.word * 32 + field.shift
    return set(range(start, start + field.length * field.width))


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
def test_no_bit_is_used_twice_and_no_word_by_two_elements(model: ir.Model) -> None:
    for block in (pack(model).fixed, pack(model).state):
        owners: dict[int, str] = {}
        used: set[int] = set()
        for field in block.fields:
            assert not used & bits(field)
            used |= bits(field)
            for bit in bits(field):
                assert owners.setdefault(bit // 32, field.element) == field.element
                assert bit < block.words * 32


@pytest.mark.parametrize("high", [1, 2, 3, 7, 8, 15, 16, 255, 256, 65535, 65536, INT32_MAX])
@pytest.mark.parametrize("count", [1, 2, 3, 31, 33])
def test_array_entries_cross_no_word(high: int, count: int) -> None:
    block = packed(variable("e.a", Int(0, 4)), variable("e.b", Int(0, high), Int(1, count)))
    field = block.fields[1]
    for entry in range(count):
        first = field.shift + entry * field.width
        assert first // 32 == (first + field.width - 1) // 32
    assert 2**field.width > high


def test_scalars_take_no_more_bits_than_they_need() -> None:
    first, second, third = packed(
        variable("e.a", Int(-3, 3)), variable("e.b", BOOL), variable("e.c", Int(INT32_MIN, INT32_MAX))
    ).fields
    assert (first.word, first.shift, first.width) == (0, 0, 3)
    assert (second.word, second.shift, second.width) == (0, 3, 1)
    assert (third.word, third.shift, third.width) == (1, 0, 32)


def test_a_float_takes_a_word_of_its_own() -> None:
    first, second, third = packed(
        variable("e.a", BOOL), variable("e.b", FLOAT, BOOL), variable("e.c", BOOL)
    ).fields
    assert (second.word, second.shift, second.width, second.length) == (1, 0, 32, 2)
    assert (first.word, third.word) == (0, 3)


def test_a_type_of_one_value_takes_no_bits() -> None:
    block = packed(variable("e.a", Int(7, 7)), variable("e.b", Int(7, 7), BOOL))
    assert [field.width for field in block.fields] == [0, 0]
    assert block.words == 1


def test_fixed_variables_are_kept_apart() -> None:
    layout = pack(ir_samples.wanderer())
    assert [field.variable for field in layout.fixed.fields] == ["map.wall"]
    assert [field.variable for field in layout.state.fields] == ["bot.at", "bot.seen"]
