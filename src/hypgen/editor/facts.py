# SPDX-License-Identifier: Apache-2.0
"""What the compiler knows of a model's names: types, derived intervals, visibility, bits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hypgen.dsl.load import Loaded
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Type, size_of


@dataclass(frozen=True)
class Fact:
    """``shown`` is a line for a hover; ``hint`` a short text for beside the name, or ""."""

    name: str
    shown: str
    hint: str
    span: Span


def facts(loaded: Loaded) -> list[Fact]:
    """Return what is known of the declarations of a model without mistakes."""
    model = loaded.model
    result = []
    for v in model.variables:
        seen = ("visible" if v.visible else "hidden") + (" fixed" if v.fixed else "")
        bits = _bits(v.type, v.indices)
        cost = "" if bits is None else f", {bits} bit{'s' if bits != 1 else ''}"
        result.append(Fact(v.name, f"{seen} {v.name}: {_typed(v.type, v.indices)}{cost}", cost[2:], v.span))
    for p in model.params:
        result.append(Fact(p.name, f"param {p.name}: {_typed(p.type, p.indices)}", "", p.span))
    for f in model.functions:
        formals = ", ".join(f"{b.name}: {b.type}" for b in f.formals)
        result.append(Fact(f.name, f"fn {f.name}({formals}): {f.type}", "", f.span))
    for o in model.observations:
        indices = tuple(b.type for b in o.binders)
        result.append(Fact(o.name, f"observe {o.name}: {_typed(o.type, indices)}", "", o.span))
    for r in model.rewards:
        reached = str(r.value.type)
        result.append(Fact(r.name, f"reward {r.name}: {reached}", reached, r.span))
    result.append(Fact(model.action.name, f"action {model.action.name}: {model.action.type}", "", _NOWHERE))
    return result


_NOWHERE = Span("", 0, 0, 0, 0)


def _typed(type_: Type, indices: tuple[Type, ...]) -> str:
    return f"{type_}[{', '.join(map(str, indices))}]" if indices else str(type_)


def _bits(type_: Type, indices: tuple[Type, ...]) -> int | None:
    """Return the bits that the values need, without what the layout adds; None where there is no count."""
    try:
        each = math.ceil(math.log2(size_of(type_)))
        return each * math.prod(size_of(i) for i in indices)
    except TypeError:  # a float
        return None
