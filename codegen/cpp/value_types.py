# SPDX-License-Identifier: Apache-2.0
"""Enums and records: how their codes are written and taken apart in C++, and how states hold variables."""

from __future__ import annotations

from collections.abc import Set

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.text import code_of, row_major, scalar, value_of
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.layout.state_layout import Block, Field
from hypgen.codegen.tree.expr import Expr, number, of, plus, shifted
from hypgen.codegen.tree.lines import text_of
from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Enum, Float, Record, Type, length_of, size_of

_CODE = "HYPGEN_FN static constexpr std::int32_t"


def enum_view(enum: Enum, names: Names) -> template_data.ValueType:
    """Return constants for plain variants; a constructor, a test and the argument for the others."""
    members, lines = names.members[enum.name], []
    for variant in enum.variants:
        name, first = members[variant.name], enum.offsets[variant.name]
        if variant.argument is None:
            lines.append(f"static constexpr std::int32_t {name} = {first};")
            continue
        kind, last = scalar(variant.argument), first + size_of(variant.argument) - 1
        code = text_of(shifted(code_of("argument", variant.argument), first))
        argument = text_of(value_of(shifted("value", -first), variant.argument))
        test, taken = members[f"is {variant.name}"], members[f"of {variant.name}"]
        lines.append(f"{_CODE} {name}({kind} argument) {{ return {code}; }}")
        lines.append(
            f"HYPGEN_FN static constexpr bool {test}(std::int32_t value) "
            f"{{ return value >= {first} && value <= {last}; }}"
        )
        lines.append(
            f"HYPGEN_FN static constexpr {kind} {taken}(std::int32_t value) {{ return {argument}; }}"
        )
    return template_data.ValueType(names.types[enum.name], tuple(lines))


def record_view(record: Record, names: Names) -> template_data.ValueType:
    """Return the constructor and the fields."""
    members = names.members[record.name]
    formals: list[str] = []
    parts: list[Expr] = []
    for field, type_ in record.fields:
        formal = f"{members[field]}_"
        formals.append(f"{scalar(type_)} {formal}")
        parts.append(code_of(formal, type_))
    code = text_of(row_major(parts, [type_ for _, type_ in record.fields]))
    lines = [f"{_CODE} {members['make']}({', '.join(formals)}) {{ return {code}; }}"]
    total = size_of(record)
    for field, type_ in record.fields:
        stride = record.stride(field)
        digit = of("value") if stride == 1 else of("value") / stride
        if stride * size_of(type_) < total:
            digit = digit % size_of(type_)
        lines.append(
            f"HYPGEN_FN static constexpr {scalar(type_)} {members[field]}(std::int32_t value) "
            f"{{ return {text_of(value_of(digit, type_))}; }}"
        )
    return template_data.ValueType(names.types[record.name], tuple(lines))


def joint_view(action: ir.Action) -> template_data.ValueType:
    """Return the components of a product action."""
    kind = scalar(action.type)
    return template_data.ValueType(
        "Joint",
        (
            f"{kind} components[{length_of(action.indices)}];",
            f"HYPGEN_FN {kind} operator[](std::int32_t i) const {{ return components[i]; }}",
        ),
    )


def words_view(
    name: str,
    purpose: str,
    block: Block,
    names: Names,
    whole: Set[str] = frozenset(),
    word: str = "std::uint32_t",
) -> template_data.Words:
    """Return a struct of words and the accessors of its variables, and of all bits of ``whole`` arrays."""
    members: list[str] = []
    for field in block.fields:
        members += _accessors(field, names.variables[field.variable], names.setters[field.variable])
        if field.variable in whole:
            members += _bits_accessors(field, names)
    return template_data.Words(name, purpose, block.words, tuple(members), word)


def history_view(block: Block, names: Names) -> template_data.Words:
    """Return the struct of what the history keeps, and its accessors."""
    members: list[str] = []
    for field in block.fields:
        members += _accessors(field, names.history[field.variable], names.history_setters[field.variable])
    return template_data.Words(
        "History", "What the default policy knows of the past.", block.words, tuple(members)
    )


def _accessors(field: Field, get: str, set_: str) -> list[str]:
    formals = [f"{scalar(t)} i{n}" for n, t in enumerate(field.indices)]
    word, shift = _place(field)
    kind, bool_ = scalar(field.type), isinstance(field.type, Bool)
    getter = f"HYPGEN_FN {kind} {get}"
    setter = f"HYPGEN_FN void {set_}"
    if field.width == 0:
        nothing = ", ".join(scalar(t) for t in field.indices)
        unused = ", ".join([*(scalar(t) for t in field.indices), kind])
        return [
            f"{getter}({nothing}) const {{ return {text_of(number(field.low))}; }}",
            f"{setter}({unused}) {{}}",
        ]
    if isinstance(field.type, Float):
        return _float_accessors(field, getter, setter)
    bits = f"bits::get(words[{word}], {shift}, {field.width})"
    read = f"{bits} != 0" if bool_ else f"static_cast<std::int32_t>({_offset(bits, field.low)})"
    stored = "static_cast<std::uint32_t>(value)"
    stored = stored if bool_ else _offset(stored, -field.low)
    put = f"words[{word}] = bits::put(words[{word}], {shift}, {field.width}, {stored});"
    if not field.indices:
        return [f"{getter}() const {{ return {read}; }}", f"{setter}({kind} value) {{", f"  {put}", "}"]
    position = f"const auto i = static_cast<std::uint32_t>({_position(field.indices)});"
    return [
        f"{getter}({', '.join(formals)}) const {{",
        f"  {position}",
        f"  return {read};",
        "}",
        f"{setter}({', '.join([*formals, f'{kind} value'])}) {{",
        f"  {position}",
        f"  {put}",
        "}",
    ]


def _float_accessors(field: Field, getter: str, setter: str) -> list[str]:
    formals = ", ".join(f"{scalar(t)} i{n}" for n, t in enumerate(field.indices))
    place = _position(field.indices)
    word = f"words[{text_of(plus(field.word, place))}]" if field.indices else f"words[{field.word}]"
    given = f"{formals}, float value" if formals else "float value"
    return [
        f"{getter}({formals}) const {{ return math::from_bits({word}); }}",
        f"{setter}({given}) {{ {word} = math::to_bits(value); }}",
    ]


def _bits_accessors(field: Field, names: Names) -> list[str]:
    getter, setter = names.bits[field.variable], names.bits_setters[field.variable]
    word, place = f"words[{field.word}]", f"{field.shift}, {field.length * field.width}"
    return [
        f"HYPGEN_FN std::int32_t {getter}() const {{",
        f"  return static_cast<std::int32_t>(bits::get({word}, {place}));",
        "}",
        f"HYPGEN_FN void {setter}(std::int32_t value) {{",
        f"  {word} = bits::put({word}, {place}, static_cast<std::uint32_t>(value));",
        "}",
    ]


def _position(indices: tuple[Type, ...]) -> str:
    return text_of(row_major([code_of(f"i{n}", t) for n, t in enumerate(indices)], indices))


def _place(field: Field) -> tuple[str, str]:
    """Return the word and the first bit of entry ``i``."""
    if not field.indices:
        return str(field.word), str(field.shift)
    if field.spread:
        return f"{field.word} + i" if field.word else "i", str(field.shift)
    step = "i" if field.width == 1 else f"i * {field.width}"
    if field.one_word:
        return str(field.word), f"{field.shift} + {step}" if field.shift else step
    lanes = 32 // field.width
    word = f"i / {lanes}" if lanes > 1 else "i"
    lane = f"i % {lanes}" if field.width == 1 else f"i % {lanes} * {field.width}"
    return f"{field.word} + {word}" if field.word else word, lane if lanes > 1 else "0"


def _offset(bits: str, low: int) -> str:
    """Add an offset modulo 2^32, which no range overflows."""
    return bits if low == 0 else f"{bits} + {low}u" if low > 0 else f"{bits} - {-low}u"
