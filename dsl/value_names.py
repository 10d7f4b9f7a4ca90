"""Values as people read them: names of enum and record codes in place of numbers."""

from __future__ import annotations

from typing import Any

from hypgen.dsl.types import Bool, Enum, Float, Record, Type, low_of, size_of


def value_name(t: Type, value: bool | int | float) -> str:
    """Return a value of a scalar type as the model would write it."""
    match t:
        case Bool():
            return "true" if value else "false"
        case Float():
            return f"{value:.9g}"
        case Enum():
            return _variant_name(t, int(value))
        case Record():
            parts = ((inner, int(value) // t.stride(name) % size_of(inner)) for name, inner in t.fields)
            return f"{t.name}({', '.join(value_name(inner, low_of(inner) + code) for inner, code in parts)})"
    return str(int(value))


def array_name(t: Type, values: Any) -> str:
    """Return a scalar, or nested lists of them, as the model would write an array."""
    if isinstance(values, list):
        return f"[{', '.join(array_name(t, v) for v in values)}]"
    return value_name(t, values)


def _variant_name(enum: Enum, code: int) -> str:
    for variant in enum.variants:
        offset = code - enum.offsets[variant.name]
        if variant.argument is None and offset == 0:
            return variant.name
        if variant.argument is not None and 0 <= offset < size_of(variant.argument):
            return f"{variant.name}({value_name(variant.argument, low_of(variant.argument) + offset)})"
    return str(code)


def action_name(t: Type, components: int, code: int) -> str:
    """Return an action's code as the model would write it; ``components`` is 1 unless it is a product."""
    digits: list[str] = []
    for _ in range(components):
        code, digit = divmod(code, size_of(t))
        digits.insert(0, value_name(t, low_of(t) + digit))
    return digits[0] if components == 1 else f"[{', '.join(digits)}]"
