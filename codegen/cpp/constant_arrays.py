# SPDX-License-Identifier: Apache-2.0
"""Constant arrays as functions that look an entry up.

A static member would have no address in device code, and nvcc would fill an automatic array at each call.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator

from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.function_builder import Builder, origin
from hypgen.codegen.cpp.text import literal, scalar
from hypgen.codegen.tree.expr import braces, call, cast, of, op
from hypgen.codegen.tree.statements import Declare, Function, Return, Text, const
from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Float, Type, size_of

_MOST_LISTED = 4096  # entries: a compiler reads more of them in a tenth of the time from a string
_WORDS_A_LINE = 8


def constant_array(table: ir.ConstantArray, context: Context) -> Function:
    """Return the function of a constant array."""
    builder = Builder(context)
    arguments = [f"i{position}" for position in range(len(table.indices))]
    for argument in arguments:
        builder.take("std::int32_t", argument)
    (_string if len(table.values) > _MOST_LISTED else _list)(table, context, arguments, builder)
    name = context.names.tables[table.name]
    return builder.done(scalar(table.type), name, [f"// {origin(table.span)}"])


def dimensions(indices: tuple[Type, ...]) -> str:
    """Return the dimensions of a C++ array that has these indices."""
    return "".join(f"[{size_of(i)}]" for i in indices)


def _list(table: ir.ConstantArray, context: Context, arguments: list[str], builder: Builder) -> None:
    values = [literal(v, table.type, context.names) for v in table.values]
    for index in reversed(table.indices):
        size = size_of(index)
        values = [braces("", *values[i : i + size]) for i in range(0, len(values), size)]
    sizes = tuple(map(size_of, table.indices))
    builder.code.add(Declare(f"static constexpr {scalar(table.type)}", "values", values[0], sizes))
    entry = of("values")
    for argument in arguments:
        entry = entry[argument]
    builder.code.add(Return(entry))


def _string(table: ir.ConstantArray, context: Context, arguments: list[str], builder: Builder) -> None:
    """Give the bits of the entries as the characters of a string."""
    entry = of(arguments[0])
    for index, argument in zip(table.indices[1:], arguments[1:], strict=True):
        entry = entry * size_of(index) + of(argument)
    builder.code.add(const("std::int32_t", "entry", entry))
    *lines, last = _lines(table)
    builder.code.add(Text(("static constexpr char32_t bits[] =", *lines, f"{last};")))
    word = of("bits")["entry"]
    match table.type:
        case Float():
            value = call("math::from_bits", cast("std::uint32_t", word))
        case Bool():
            value = op(word, "!=", 0)
        case _:
            value = cast("std::int32_t", word)
    builder.code.add(Return(value))


def _lines(table: ir.ConstantArray) -> Iterator[str]:
    is_float = isinstance(table.type, Float)
    entries = array("f", table.values) if is_float else array("i", map(int, table.values))
    words = [f"\\x{word:x}" for word in array("I", entries.tobytes())]
    for at in range(0, len(words), _WORDS_A_LINE):
        yield f'    U"{"".join(words[at : at + _WORDS_A_LINE])}"'
