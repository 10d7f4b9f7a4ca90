# SPDX-License-Identifier: Apache-2.0
"""What callers of a library give and get: values at the start, what is seen in a step, and what is hidden."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping

from hypgen.dsl import ir
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.types import Bool, Enum, Float, Record, Type, flat_indices, length_of, low_of, size_of

_CHOOSES = (ir.Certain, ir.IfDist, ir.LetDist)  # distributions that draw only where one inside them does


def number(value: bool | int | float) -> str:
    """Return C++ for a number."""
    if isinstance(value, float) and math.isinf(value):
        return ("-" if value < 0 else "") + "std::numeric_limits<double>::infinity()"
    if isinstance(value, int):
        return str(int(value)) + (".0" if abs(int(value)) >= 2**31 else "")
    return repr(value)


def places(model: ir.Model) -> dict[str, int]:
    """Return where the values of each variable begin among those of all, as ``export_state`` writes them."""
    ends = itertools.accumulate((length_of(v.indices) for v in model.variables), initial=0)
    return {variable.name: first for variable, first in zip(model.variables, ends, strict=False)}


def visible_fields(model: ir.Model, name_functions: Mapping[str, str]) -> list[str]:
    """Return C++ for a ``ValueField`` of each visible variable; ``name_functions`` name codes, by type."""
    drawn = drawn_at_start(model)
    return [
        _field(v.name, v.type, v.indices, name_functions, drawn=v.name in drawn)
        for v in model.variables
        if v.visible
    ]


def hidden_fields(model: ir.Model, name_functions: Mapping[str, str]) -> list[str]:
    """Return C++ for a ``ValueField`` of each hidden variable."""
    return [_field(v.name, v.type, v.indices, name_functions) for v in model.variables if not v.visible]


def seen_fields(model: ir.Model, name_functions: Mapping[str, str]) -> list[str]:
    """Return C++ for a ``ValueField`` of each field of the observation key."""
    return [_field(k.name, k.type, k.indices, name_functions) for k in model.key]


def drawn_at_start(model: ir.Model) -> set[str]:
    """Return the variables whose first value a draw decides, directly or through others."""
    functions = {f.name: f for f in model.functions}
    lets = {e.name: e for e in model.lets}
    drawn: set[str] = set()
    for init in model.inits:  # in dependency order, but for those of a group
        nodes = [node for node, _ in reached((init.dist,), functions, lets)]
        reads = {node.variable for node in nodes if isinstance(node, ir.StateRead)} - {init.variable}
        draws = any(isinstance(node, ir.Dist) and not isinstance(node, _CHOOSES) for node in nodes)
        if draws or init.group is not None or reads & drawn:
            drawn.add(init.variable)
    return drawn


def _field(
    name: str, type_: Type, indices: tuple[Type, ...], name_functions: Mapping[str, str], drawn: bool = False
) -> str:
    function = "{}"
    match type_:
        case Bool():
            kind, low, high = "kBool", "0", "1"
        case Float(prob=True):
            kind, low, high = "kFloat", "0", "1"
        case Float(low=least, high=most):
            kind, low, high = "kFloat", number(least), number(most)
        case Enum(name=named) | Record(name=named):
            kind, low, high = "kNamed", "0", str(size_of(type_) - 1)
            function = name_functions[named]
        case _:
            kind, low = "kInt", number(low_of(type_))
            high = number(low_of(type_) + size_of(type_) - 1)
    dims = ", ".join(str(size_of(i)) for i in flat_indices(indices))
    end = ", true" if drawn else ""
    return f"{{{json.dumps(name)}, {{{dims}}}, hypgen::ValueKind::{kind}, {low}, {high}, {function}{end}}}"
