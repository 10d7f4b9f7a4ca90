# SPDX-License-Identifier: Apache-2.0
"""The header of a library for C: the model's enums, and places of values in arrays."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import TypeAlias

from hypgen.codegen.cpp import template_data
from hypgen.codegen.layout.naming import Scope, snake_case
from hypgen.dsl import ir
from hypgen.dsl.ir import key_digits
from hypgen.dsl.types import Enum, Type, length_of, low_of, size_of

Fields: TypeAlias = list[tuple[str, tuple[Type, ...]]]
Namer: TypeAlias = Callable[..., str]


def c_groups(model: ir.Model, stem: str) -> tuple[template_data.Group, ...]:
    """Return the enumerators of the header."""
    scope, prefix = Scope(), stem.upper()

    def name(*parts: str) -> str:
        words = [re.sub(r"\W", "_", snake_case(part)).upper() for part in parts]
        return scope.unique("_".join([prefix, *words]))

    visible: Fields = [(v.name, v.indices) for v in model.variables if v.visible]
    seen: Fields = [(k.name, k.indices) for k in model.key]
    groups: list[tuple[str, Iterator[str]]] = [
        ("Sizes.", _sizes(name, model, visible, seen)),
        ("Places of the visible variables in the values of hypgen_reset.", _places(name, "at", visible)),
        ("Places of what is seen in the values of hypgen_update_values.", _places(name, "sees", seen)),
        *((f"The codes of {enum.name}.", _codes(name, enum)) for enum in model.enums),
    ]
    return tuple(template_data.Group(title, lines) for title, found in groups if (lines := tuple(found)))


def _sizes(name: Namer, model: ir.Model, visible: Fields, seen: Fields) -> Iterator[str]:
    yield f"{name('actions')} = {model.action.count},"
    yield f"{name('visible')} = {sum(length_of(i) for _, i in visible)},"
    yield f"{name('seen')} = {sum(length_of(i) for _, i in seen)},"
    yield f"{name('key_words')} = {key_digits.word_count(model.key)},"


def _places(name: Namer, kind: str, fields: Fields) -> Iterator[str]:
    place = 0
    for field, indices in fields:
        count = length_of(indices)
        yield f"{name(kind, field)} = {place}," + (f" /* the first of {count} */" if indices else "")
        place += count


def _codes(name: Namer, enum: Enum) -> Iterator[str]:
    for variant in enum.variants:
        line = f"{name(enum.name, variant.name)} = {enum.offsets[variant.name]},"
        if variant.argument is not None:
            low, size = low_of(variant.argument), size_of(variant.argument)
            line += f" /* the first of {size}, of argument {low} */"
        yield line
