# SPDX-License-Identifier: Apache-2.0
"""Words, enums and records in lanes: a value of each lane, or one for all of them."""

from __future__ import annotations

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.text import code_of, row_major, value_of
from hypgen.codegen.lanes.lane_text import on_lanes
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.layout.state_layout import Block, Field
from hypgen.codegen.tree.expr import Expr, Literal, of, op, shifted
from hypgen.codegen.tree.lines import text_of
from hypgen.codegen.tree.walks import mapped
from hypgen.dsl.types import Bool, Enum, Float, Record, size_of


def words_in_lanes(
    name: str, block: Block, getters: dict[str, str], setters: dict[str, str]
) -> template_data.Words:
    """Return a struct of words and the accessors of its variables."""
    members: list[str] = []
    for field in block.fields:
        members += _accessors(field, getters[field.variable], setters[field.variable])
    return template_data.Words(name, "", block.words, tuple(members))


def _accessors(field: Field, get: str, set_: str) -> list[str]:
    kind = "lanes::" + (
        "Mask" if isinstance(field.type, Bool) else "Float" if isinstance(field.type, Float) else "Int"
    )
    names = [f"i{n}" for n in range(len(field.indices))]
    position = _position(field)
    if position == "i0":
        names = ["i"]
    template = [f"template <{', '.join(f'class I{n}' for n in range(len(names)))}>"] if names else []
    formals = [f"I{n} {name}" for n, name in enumerate(names)]
    getter = f"HYPGEN_FN {kind} {get}"
    setter = f"HYPGEN_FN void {set_}"
    if field.width == 0:
        unused = ", ".join(["lanes::Mask", *(f"I{n}" for n in range(len(names))), kind])
        nothing = ", ".join(f"I{n}" for n in range(len(names)))
        return [
            *template,
            f"{getter}({nothing}) const {{ return {field.low}; }}",
            *template,
            f"{setter}({unused}) {{}}",
        ]
    place = [f"  const auto i = {position};"] if names and names != ["i"] else []
    word, shift = _place(field)
    if isinstance(field.type, Float):
        word = _from(field.word, "i") if names else str(field.word)
        read = f"lanes::from_bits(lanes::word_at(words, {word}))"
        put = f"lanes::put_word(on, words, {word}, lanes::to_bits(value));"
    else:
        bits = f"lanes::get(words, {word}, {shift}, {field.width})"
        as_int = f"lanes::as<std::int32_t>({bits})"
        low = f" + {field.low}" if field.low > 0 else f" - {-field.low}" if field.low else ""
        read = f"{bits} != 0u" if isinstance(field.type, Bool) else f"{as_int}{low}"
        back = f" - {field.low}" if field.low > 0 else f" + {-field.low}" if field.low else ""
        stored = "value" if not back else f"value{back}"
        put = f"lanes::put(on, words, {word}, {shift}, {field.width}, lanes::as<std::uint32_t>({stored}));"
    return [
        *template,
        f"{getter}({', '.join(formals)}) const {{",
        *place,
        f"  return {read};",
        "}",
        *template,
        f"{setter}({', '.join(['lanes::Mask on', *formals, f'{kind} value'])}) {{",
        *place,
        f"  {put}",
        "}",
    ]


def _position(field: Field) -> str:
    codes = [code_of(f"i{n}", t) for n, t in enumerate(field.indices)]
    return text_of(_in_lanes(row_major(codes, field.indices)))


def _place(field: Field) -> tuple[str, str]:
    """Return the word and the first bit of entry ``i``."""
    if not field.indices:
        return str(field.word), str(field.shift)
    if field.spread:
        return _from(field.word, "i"), str(field.shift)
    if field.one_word:
        return str(field.word), _from(field.shift, f"i * {field.width}" if field.width > 1 else "i")
    entries = 32 // field.width
    return _from(field.word, f"lanes::over<{entries}>(i)"), f"lanes::rest<{entries}>(i) * {field.width}"


def _from(first: int, more: str) -> str:
    return f"{first} + {more}" if first else more


def enum_in_lanes(enum: Enum, names: Names) -> template_data.ValueType:
    """Return what takes arguments of an enum's variants; its constants are those of the model."""
    members, lines = names.members[enum.name], []
    for variant in enum.variants:
        if variant.argument is None:
            continue
        first, last = enum.offsets[variant.name], enum.offsets[variant.name] + size_of(variant.argument) - 1
        lines += _function(
            members[variant.name], ["argument"], shifted(code_of("argument", variant.argument), first)
        )
        inside = on_lanes("both", op("value", ">=", first), op("value", "<=", last))
        lines += _function(members[f"is {variant.name}"], ["value"], inside)
        lines += _function(
            members[f"of {variant.name}"], ["value"], value_of(shifted("value", -first), variant.argument)
        )
    return template_data.ValueType(names.types[enum.name], tuple(lines))


def record_in_lanes(record: Record, names: Names) -> template_data.ValueType:
    """Return the constructor and the fields of a record."""
    members = names.members[record.name]
    formals = [f"{members[field]}_" for field, _ in record.fields]
    parts = [code_of(formal, type_) for formal, (_, type_) in zip(formals, record.fields, strict=True)]
    lines = _function(members["make"], formals, row_major(parts, [type_ for _, type_ in record.fields]))
    for field, type_ in record.fields:
        stride = record.stride(field)
        digit = of("value") if stride == 1 else of("value") / stride
        if stride * size_of(type_) < size_of(record):
            digit = digit % size_of(type_)
        lines += _function(members[field], ["value"], value_of(digit, type_))
    return template_data.ValueType(names.types[record.name], tuple(lines))


def _function(name: str, formals: list[str], value: Expr) -> list[str]:
    template = ", ".join(f"class T{n}" for n in range(len(formals)))
    arguments = ", ".join(f"T{n} {formal}" for n, formal in enumerate(formals))
    return [
        f"template <{template}>",
        f"HYPGEN_FN static constexpr auto {name}({arguments}) {{ return {text_of(_in_lanes(value))}; }}",
    ]


def _in_lanes(value: Expr) -> Expr:
    def change(expr: Expr) -> Expr | None:
        if isinstance(expr, Literal) and expr.text.startswith("static_cast<"):
            return Literal(f"lanes::{expr.text.replace('static_cast', 'as')}")
        return None

    found: Expr = mapped(value, change)
    return found


def joint_in_lanes(components: int) -> tuple[str, ...]:
    """Return the members of the components of a product action."""
    return (
        f"lanes::Int components[{components}];",
        "template <class I>",
        "HYPGEN_FN lanes::Int operator[](I i) const { return lanes::at(components, i); }",
    )
