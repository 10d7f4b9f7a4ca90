# SPDX-License-Identifier: Apache-2.0
"""Values as text, the way the language writes them, and back: for people who run a model."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Enum, Float, Record, Type, length_of, low_of, size_of


def value_text(value: bool | int | float, t: Type) -> str:
    """Return a value (an enum's or record's code) as the language writes it."""
    match t:
        case Bool():
            return "true" if value else "false"
        case Float():
            return f"{value:.6g}"
        case Enum():
            return _variant_text(int(value), t)
        case Record(name, fields):
            parts, rest = [], int(value)
            for _, field in reversed(fields):
                rest, digit = divmod(rest, size_of(field))
                parts.append(value_text(digit + low_of(field), field))
            return f"{name}({', '.join(reversed(parts))})"
    return str(value)


def _variant_text(code: int, t: Enum) -> str:
    for variant in reversed(t.variants):
        offset = t.offsets[variant.name]
        if code >= offset:
            if variant.argument is None:
                return variant.name
            return f"{variant.name}({value_text(code - offset + low_of(variant.argument), variant.argument)})"
    return str(code)


def index_texts(indices: tuple[Type, ...]) -> list[tuple[str, ...]]:
    """Return the texts of an array's indexes, row-major; one empty tuple for a scalar."""
    places: list[tuple[str, ...]] = [()]
    for index in indices:
        values = [value_text(low_of(index) + i, index) for i in range(size_of(index))]
        places = [(*place, value) for place in places for value in values]
    return places


def entry_names(name: str, element: str | None, indices: tuple[Type, ...], model: ir.Model) -> list[str]:
    """Return what the entries of a variable or observation are called: ``rock[3].good``, ``map.wall[0, 2]``.

    ``indices`` are those of the whole array, row-major, a family's member first.
    """
    owner = next((e for e in model.elements if e.name == element), None)
    if owner is None:
        return [name + _brackets(place) for place in index_texts(indices)]
    own = name.removeprefix(f"{owner.name}.")
    members = 0 if owner.binder is None else 1
    return [
        f"{owner.name}{_brackets(place[:members])}.{own}{_brackets(place[members:])}"
        for place in index_texts(indices)
    ]


def factor_texts(factor: ir.Factor, model: ir.Model) -> list[tuple[str, list[str]]]:
    """Return for each member of a factor what it is called, and its joint values' texts.

    ``rock[3].good`` and ``true``, or ``ghost[1]`` and ``at = 3, angry = false`` where it has several entries.
    """
    members = [()] if factor.binder is None else index_texts((factor.binder.type,))
    result = []
    for number, member in enumerate(members):
        entries: list[tuple[str, Type]] = []
        for v in map(model.variable, factor.variables):
            names = entry_names(v.name, v.element, v.indices, model)
            count = len(names) // len(members)
            entries += [(name, v.type) for name in names[number * count : (number + 1) * count]]
        label = f"{factor.element}{_brackets(member)}"
        if len(entries) == 1:
            (name, t), *_ = entries
            result.append((name, [value_text(code + low_of(t), t) for code in range(factor.size)]))
        else:
            named = [(name.removeprefix(f"{label}."), t) for name, t in entries]
            result.append((label, [_joint_text(code, named) for code in range(factor.size)]))
    return result


def _joint_text(code: int, entries: list[tuple[str, Type]]) -> str:
    parts = []
    for name, t in reversed(entries):
        code, digit = divmod(code, size_of(t))
        parts.append(f"{name} = {value_text(digit + low_of(t), t)}")
    return ", ".join(reversed(parts))


def _brackets(place: Sequence[str]) -> str:
    return f"[{', '.join(place)}]" if place else ""


def array_text(values: Sequence[bool | int | float], t: Type, indices: tuple[Type, ...]) -> str:
    """Return an array's entries, row-major, as nested lists, under the names of an enum if one is the index.

    Each row of an array of several dimensions is on a line of its own. A scalar's value stands alone.
    """
    if not indices:
        return value_text(values[0], t)
    step = length_of(indices[1:])
    rows = [array_text(values[i : i + step], t, indices[1:]) for i in range(0, len(values), step)]
    if isinstance(indices[0], Enum):
        rows = [f"{value_text(code, indices[0])}: {row}" for code, row in enumerate(rows)]
    if len(indices) == 1:
        return f"[{', '.join(rows)}]"
    inner = ",\n".join(rows)
    return f"[\n{textwrap.indent(inner, '  ')}\n]"


def action_text(code: int, action: ir.Action) -> str:
    """Return an action's name, of a joint action ``(north, sample)``, as solvers print it."""
    if not action.indices:
        return value_text(code + low_of(action.type), action.type)
    parts, size = [], size_of(action.type)
    for _ in range(length_of(action.indices)):
        code, digit = divmod(code, size)
        parts.append(value_text(digit + low_of(action.type), action.type))
    return f"({', '.join(reversed(parts))})"


def find_action(text: str, action: ir.Action) -> list[int]:
    """Return the codes of the actions that ``text`` may mean: the one so called, or all that it abbreviates.

    Brackets and commas may be left out and each word may be cut short: ``ch 3`` for ``check(3)``.
    """
    words = _words(text)
    found = []
    for code in range(action.count):
        name = _words(action_text(code, action))
        if name == words:
            return [code]
        if len(name) == len(words) and all(map(_abbreviates, words, name)):
            found.append(code)
    return found


def actions_with(text: str, action: ir.Action) -> list[int]:
    """Return the codes of the actions whose names have the words of ``text`` in order, cut short or not."""
    found = []
    for code in range(action.count):
        name = iter(_words(action_text(code, action)))
        if all(any(_abbreviates(word, other) for other in name) for word in _words(text)):
            found.append(code)
    return found


def _words(text: str) -> list[str]:
    return re.findall(r"-?[\w.]+", text)


def _abbreviates(word: str, name: str) -> bool:
    return name.startswith(word) if word[0].isalpha() else name == word
