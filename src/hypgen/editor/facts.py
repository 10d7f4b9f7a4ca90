# SPDX-License-Identifier: Apache-2.0
"""What the compiler knows of a model's names: types, derived intervals, visibility, bits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hypgen.dsl import ir
from hypgen.dsl.load import Loaded
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Bool, Float, Int, Type, size_of


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
        cost = _cost(v.type, v.indices)
        result.append(Fact(v.name, f"{seen} {v.name}: {_typed(v.type, v.indices)}{cost}", cost[2:], v.span))
    for p in model.params:
        result.append(Fact(p.name, f"param {p.name}: {_typed(p.type, p.indices)}{_default(p)}", "", p.span))
    for let in model.all_lets:
        kind, reached = "drawn let" if let.draws else "let", str(let.dist.type)
        of = () if let.binder is None else (let.binder.type,)
        result.append(Fact(let.name, f"{kind} {let.name}: {_typed(let.dist.type, of)}", reached, let.span))
    for f in model.functions:
        formals = ", ".join(f"{b.name}: {b.type}" for b in f.formals)
        result.append(Fact(f.name, f"fn {f.name}({formals}): {f.type}", "", f.span))
    for o in model.observations:
        indices = tuple(b.type for b in o.binders)
        cost = _cost(o.type, indices)
        result.append(Fact(o.name, f"observe {o.name}: {_typed(o.type, indices)}{cost}", cost[2:], o.span))
    for r in model.rewards:
        reached = str(r.value.type)
        result.append(Fact(r.name, f"reward {r.name}: {reached}", reached, r.span))
    result.append(Fact(model.action.name, f"action {model.action.name}: {model.action.type}", "", _NOWHERE))
    return result


_NOWHERE = Span("", 0, 0, 0, 0)


def _typed(type_: Type, indices: tuple[Type, ...]) -> str:
    return f"{type_}[{', '.join(map(str, indices))}]" if indices else str(type_)


def _default(param: ir.Param) -> str:
    """Return the value of a param that has one, where that is a number or a truth value."""
    if param.indices or param.default is None or not isinstance(param.type, Bool | Int | Float):
        return ""
    (value,) = param.default
    return f" = {str(bool(value)).lower()}" if isinstance(param.type, Bool) else f" = {value:.6g}"


def _cost(type_: Type, indices: tuple[Type, ...]) -> str:
    bits = _bits(type_, indices)
    return "" if bits is None else f", {bits} bit{'s' if bits != 1 else ''}"


def _bits(type_: Type, indices: tuple[Type, ...]) -> int | None:
    """Return the bits that the values need, without what the layout adds; None where there is no count."""
    try:
        each = math.ceil(math.log2(size_of(type_)))
        return each * math.prod(size_of(i) for i in indices)
    except TypeError:  # a float
        return None
