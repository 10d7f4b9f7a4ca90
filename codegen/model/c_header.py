# SPDX-License-Identifier: Apache-2.0
"""The header of a library for C: the model's enums and records, and places of values in arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import reduce
from typing import TypeAlias

from hypgen.codegen.cpp import template_data
from hypgen.codegen.layout.naming import Scope, snake_case
from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import Choice, Expr, all_of, member, not_, number, of, op, plus, shifted
from hypgen.codegen.tree.lines import statements
from hypgen.codegen.tree.statements import Block, Declare, Return, assign, for_below, for_down, var, when
from hypgen.dsl import ir
from hypgen.dsl.ir import key_digits
from hypgen.dsl.types import Bool, Enum, Int, Record, Type, Variant, length_of, low_of, size_of

Fields: TypeAlias = list[tuple[str, tuple[Type, ...]]]


class CHeader:
    """Makes what the header declares. Functions give -1 where an argument is no value of its type."""

    def __init__(self, model: ir.Model, stem: str) -> None:
        self._model = model
        self._stem = stem
        self._constants = Scope(prefixed=True)
        # Names that hypgen.h and its includes define begin in other ways than with the model's name.
        self._names = Scope(prefixed=True)

    def enumerators(self) -> tuple[template_data.Group, ...]:
        """Return sizes, places and codes."""
        model = self._model
        visible: Fields = [(v.name, v.indices) for v in model.variables if v.visible]
        seen: Fields = [(k.name, k.indices) for k in model.key]
        groups: list[tuple[str, Iterator[str]]] = [
            ("Sizes.", self._sizes(visible, seen)),
            ("Places of the visible variables in the values of hypgen_reset.", self._places("at", visible)),
            ("Places of what is seen in the values of hypgen_update_values.", self._places("sees", seen)),
            *((f"The codes of {enum.name}.", self._codes(enum)) for enum in model.enums),
        ]
        return tuple(template_data.Group(title, lines) for title, found in groups if (lines := tuple(found)))

    def functions(self) -> tuple[template_data.CGroup, ...]:
        """Return records with their codes, variants with arguments, and the action's number."""
        enums = [template_data.CGroup((), tuple(self._variants(enum))) for enum in self._model.enums]
        records = [self._record(record) for record in self._model.records]
        action = template_data.CGroup((), tuple(self._action(self._model.action)))
        return tuple(group for group in (*enums, *records, action) if group.functions)

    def _constant(self, *parts: str) -> str:
        return self._constants.unique("_".join([self._stem, *map(_word, parts)]).upper())

    def _name(self, *parts: str) -> str:
        return self._names.unique("_".join([self._stem, *map(_word, parts)]))

    def _sizes(self, visible: Fields, seen: Fields) -> Iterator[str]:
        yield f"{self._constant('actions')} = {self._model.action.count},"
        yield f"{self._constant('visible')} = {sum(length_of(i) for _, i in visible)},"
        yield f"{self._constant('seen')} = {sum(length_of(i) for _, i in seen)},"
        yield f"{self._constant('key_words')} = {key_digits.word_count(self._model.key)},"

    def _places(self, kind: str, fields: Fields) -> Iterator[str]:
        place = 0
        for field, indices in fields:
            count = length_of(indices)
            note = f" /* the first of {count} */" if indices else ""
            yield f"{self._constant(kind, field)} = {place},{note}"
            place += count

    def _codes(self, enum: Enum) -> Iterator[str]:
        for variant in enum.variants:
            line = f"{self._constant(enum.name, variant.name)} = {enum.offsets[variant.name]},"
            if variant.argument is not None:
                low, size = low_of(variant.argument), size_of(variant.argument)
                line += f" /* the first of {size}, of argument {low} */"
            yield line

    def _variants(self, enum: Enum) -> Iterator[template_data.Function]:
        for variant in enum.variants:
            if variant.argument is not None:
                yield from self._variant(enum, variant, variant.argument)

    def _variant(self, enum: Enum, variant: Variant, argument: Type) -> Iterator[template_data.Function]:
        first, low, size = enum.offsets[variant.name], low_of(argument), size_of(argument)
        yield _function(
            f"The code of {enum.name}'s {variant.name}(argument).",
            f"int32_t {self._name(enum.name, variant.name)}(int32_t argument)",
            [Return(Choice(_inside(of("argument"), argument), shifted("argument", first - low), number(-1)))],
        )
        yield _function(
            f"Whether a code of {enum.name} is one of {variant.name}.",
            f"int {self._name(enum.name, 'is', variant.name)}(int32_t code)",
            [Return(op(op("code", ">=", first), "&&", op("code", "<", first + size)))],
        )
        yield _function(
            f"The argument of {variant.name}, of a code that is one of it.",
            f"int32_t {self._name(enum.name, variant.name, 'argument')}(int32_t code)",
            [Return(shifted("code", low - first))],
        )

    def _record(self, record: Record) -> template_data.CGroup:
        """Return a struct and the way to its code and back."""
        name = self._name(record.name)
        members = Scope({"restrict"})  # C's only word that C++ lacks and a model may use
        fields = [(members.unique(_word(field)), field, type_) for field, type_ in record.fields]
        struct = [f"int32_t {part}; /* {_values(type_)} */" for part, _, type_ in fields]
        packing: Block = []
        unpacking: Block = []
        tests = all_of([_inside(member("value", part), type_) for part, _, type_ in fields])
        terms = [_digit(member("value", part), type_, record.stride(field)) for part, field, type_ in fields]
        packing.append(when(not_(tests), Return(number(-1)), short=False))
        packing.append(Return(reduce(plus, terms)))
        unpacking.append(Declare(name, "value"))
        for part, field, type_ in fields:
            unpacking.append(assign(member("value", part), _value(record, field, type_)))
        unpacking.append(Return(of("value")))
        return template_data.CGroup(
            (f"typedef struct {name} {{", *(f"  {line}" for line in struct), f"}} {name};"),
            (
                _function(
                    f"The code of a {record.name}.",
                    f"int32_t {self._name(record.name, 'code')}({name} value)",
                    packing,
                ),
                _function(
                    f"The {record.name} of a code.",
                    f"{name} {self._name(record.name, 'of')}(int32_t code)",
                    unpacking,
                ),
            ),
        )

    def _action(self, action: ir.Action) -> Iterator[template_data.Function]:
        """Yield the way to an action's number and back, where that is not its code."""
        name, size, low = self._name("action"), size_of(action.type), low_of(action.type)
        if action.indices:
            count = length_of(action.indices)
            code = Code()
            code.add(var("int32_t", "action", 0))
            part = of("parts")["i"]
            with code.block(for_below("i", count, "int")):
                code.add(when(not_(_inside(part, action.type)), Return(number(-1))))
                code.add(assign("action", plus(of("action") * size, shifted(part, -low))))
            code.add(Return(of("action")))
            yield _function(
                f"The action with these {count} parts: the number that hypgen_decision has.",
                f"int32_t {name}(const int32_t* parts)",
                code.body,
            )
            code = Code()
            with code.block(for_down("i", count)):
                code.add(assign(part, shifted(of("action") % size, low)))
                code.add(assign("action", size, "/="))
            head = f"void {self._name('action', 'parts')}(int32_t action, int32_t* parts)"
            yield _function(f"The {count} parts of an action.", head, code.body)
        elif low:
            test = _inside(of("value"), action.type)
            yield _function(
                "The action of a value: the number that hypgen_decision has.",
                f"int32_t {name}(int32_t value)",
                [Return(Choice(test, shifted("value", -low), number(-1)))],
            )
            head = f"int32_t {self._name('action', 'value')}(int32_t action)"
            yield _function("The value of an action.", head, [Return(shifted("action", low))])


def _word(part: str) -> str:
    return re.sub(r"\W", "_", snake_case(part))


def _function(comment: str, head: str, body: Block) -> template_data.Function:
    return template_data.Function(
        (f"/* {comment} */",), (f"static inline {head} {{",), tuple(statements(body))
    )


def _inside(value: Expr, type_: Type) -> Expr:
    """Return a test whether a value is one of a type."""
    low = low_of(type_)
    return op(op(value, ">=", low), "&&", op(value, "<=", low + size_of(type_) - 1))


def _digit(value: Expr, type_: Type, stride: int) -> Expr:
    """Return what a field adds to its record's code."""
    low = low_of(type_)
    digit = shifted(value, -low)
    return digit if stride == 1 else digit * stride


def _value(record: Record, field: str, type_: Type) -> Expr:
    """Return a field of a code."""
    stride = record.stride(field)
    digit = of("code") if stride == 1 else of("code") / stride
    if stride * size_of(type_) < size_of(record):
        digit = digit % size_of(type_)
    return shifted(digit, low_of(type_))


def _values(type_: Type) -> str:
    match type_:
        case Bool():
            return "0 or 1"
        case Int(low=low, high=high):
            return f"{low} .. {high}"
    return f"a code of {type_}"
