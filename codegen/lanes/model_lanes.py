# SPDX-License-Identifier: Apache-2.0
"""What of a model is put into lanes, or why nothing is."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.function_builder import laid_out
from hypgen.codegen.lanes.lane_text import NoLanes
from hypgen.codegen.lanes.lane_types import enum_in_lanes, joint_in_lanes, record_in_lanes, words_in_lanes
from hypgen.codegen.lanes.predication import predicated
from hypgen.codegen.lanes.repeated_calls import without_repeated_calls
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.layout.state_layout import Layout
from hypgen.codegen.tree.effects import Effects
from hypgen.codegen.tree.passes import without_last_writes
from hypgen.codegen.tree.statements import Function
from hypgen.codegen.tree.walks import calls
from hypgen.dsl import ir
from hypgen.dsl.types import length_of, size_of

_ROLLOUT = {"default_policy", "step", "tail"}
_NARROW_KEY = 2**31
_MOST_TERMS = 31  # whose sum a double holds exactly, however large each is


def in_lanes(
    model: ir.Model, names: Names, layout: Layout, functions: Sequence[Function], has_lower: bool
) -> tuple[template_data.Lanes | None, str]:
    """Return what a rollout of the default policy takes, in lanes; or None and the reason."""
    if has_lower:
        return None, "a lower bound replaces rollouts"
    terms = sum(1 if r.binder is None else size_of(r.binder.type) for r in model.rewards)
    if not model.rewards_fit and terms > _MOST_TERMS:
        return None, "many rewards may leave their range"
    try:
        return _lanes(model, names, layout, functions), ""
    except NoLanes as reason:
        return None, str(reason)


def _lanes(
    model: ir.Model, names: Names, layout: Layout, functions: Sequence[Function]
) -> template_data.Lanes:
    has_history = bool(layout.history.fields)
    roots = _ROLLOUT | ({"roll_history"} if has_history else set())
    reached = calls(functions, roots)
    made = predicated([f for f in functions if f.name in reached])
    known = {f.name: f for f in made}
    found = without_repeated_calls([without_last_writes(f, Effects(f, known)) for f in made])
    words = [
        words_in_lanes("Fixed", layout.fixed, names.variables, names.setters),
        words_in_lanes("State", layout.state, names.variables, names.setters),
    ]
    if has_history:
        words.append(words_in_lanes("History", layout.history, names.history, names.history_setters))
    keys = math.prod(k.size for k in model.key)
    return template_data.Lanes(
        key="std::uint32_t" if keys <= _NARROW_KEY else "std::uint64_t",
        has_history=has_history,
        types=(
            *(enum_in_lanes(e, names) for e in model.enums),
            *(record_in_lanes(r, names) for r in model.records),
        ),
        joint=joint_in_lanes(length_of(model.action.indices)) if model.action.indices else (),
        words=tuple(words),
        functions=tuple(map(laid_out, found)),
    )
