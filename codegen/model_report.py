# SPDX-License-Identifier: Apache-2.0
"""The compiler's facts of a model, as plain data: updates, draws, layout, rewards, bounds, belief."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hypgen.codegen.belief import redraw
from hypgen.codegen.bounds.groups import Part, describe, runs
from hypgen.codegen.bounds.relaxation import relax
from hypgen.codegen.layout.state_layout import WORD, Block, pack
from hypgen.codegen.passes.enumerable import continuous_draws
from hypgen.codegen.passes.partition import Share, most_warps, partition, run_count, shares, written_words
from hypgen.codegen.project import lower
from hypgen.dsl import ir
from hypgen.dsl.ir import key_digits
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Float, Int, Type, length_of, low_of, size_of

WARPS = (1, 2, 4, 8)  # of a block, as examples


def explain(model: ir.Model) -> dict[str, Any]:
    """Return all that ``hypgen explain`` tells; sizes are in bytes where a name says nothing else."""
    state = pack(model).state
    stages = [shares(stage, state) for stage in partition(model)]
    return {
        "model": model.name,
        "discount": model.discount,
        "horizon": model.horizon,
        "params": [_param(p) for p in model.params],
        "actions": _actions(model),
        "observations": _observations(model),
        "state": _state(model),
        "stages": [[_task(share, state) for share in stage] for stage in stages],
        "warps": _warps(stages),
        "draws": _draws(model),
        "rewards": _rewards(model),
        "bounds": {name: _bound(model, name) for name in ("upper", "lower", "tail")},
        "relaxation": _relaxation(model),
        "exact": _exact(model),
        "policy": _policy(model),
        "lanes": {"reason": lower(model)[0].no_lanes},
        "belief": _belief(model),
        "drawings": _drawings(model),
    }


def _param(param: ir.Param) -> dict[str, Any]:
    return {
        "name": param.name,
        "type": str(param.type),
        "entries": length_of(param.indices),
        "has_default": param.default is not None,
    }


def _actions(model: ir.Model) -> dict[str, Any]:
    action = model.action
    return {
        "name": action.name,
        "type": str(action.type),
        "indices": [str(i) for i in action.indices],
        "count": action.count,
        "legal": "declared" if "legal" in model.spans else "all",
    }


def _observations(model: ir.Model) -> dict[str, Any]:
    count = math.prod(field.size**field.length for field in model.key)
    return {
        "count": count if count <= 2**64 else None,
        "bits": (count - 1).bit_length(),
        "words": key_digits.word_count(model.key),
        "digits": [
            {
                "name": field.name,
                "kind": "observation" if field.observed else "visible variable",
                "type": str(field.type),
                "entries": field.length,
                "values": field.size,
            }
            for field in model.key
        ],
    }


def _exact(model: ir.Model) -> dict[str, Any]:
    """Return whether ``hypgen solve`` takes the model, as far as can be told without finding its states."""
    obstacles = [
        {"reason": f"'{name}' is drawn from a continuous law", "line": span.line}
        for name, span in continuous_draws(model)
    ]
    bits = _state(model)["bits"] + math.ceil(math.log2(model.horizon or 1))
    return {"obstacles": obstacles, "most_states_log2": bits}


# State and updates ---------------------------------------------------------------------------------


def _state(model: ir.Model) -> dict[str, Any]:
    packed = pack(model)
    fixed, dynamic = _block(packed.fixed, model), _block(packed.state, model)
    return {
        "bytes": fixed["bytes"] + dynamic["bytes"],
        "bits": sum(v["width"] * v["entries"] for block in (fixed, dynamic) for v in block["variables"]),
        "fixed": fixed,
        "dynamic": dynamic,
    }


def _block(block: Block, model: ir.Model) -> dict[str, Any]:
    hidden = {v.name for v in model.variables if not v.visible}
    return {
        "bytes": block.words * WORD // 8 if block.fields else 0,
        "variables": [
            {
                "name": field.variable,
                "visible": field.variable not in hidden,
                "type": str(field.type),
                "indices": [str(i) for i in field.indices],
                "entries": field.length,
                "word": field.word,
                "shift": field.shift,
                "width": field.width,
                "stride": field.stride,
            }
            for field in block.fields
        ],
    }


def _task(share: Share, state: Block) -> dict[str, Any]:
    """Return an element update: a task of its own, whose runs of members go to different warps."""
    update = share.update
    return {
        "element": update.element.name,
        "members": update.members,
        "writes": [assign.variable for assign in update.assigns],
        "words": sorted(frozenset[int]().union(*written_words(update, state))),
        "after": sorted({name for assign in update.assigns for name in assign.reads}),
        "from_key": update.observed,
        "first": share.first,
        "runs": share.runs,
        "grain": share.grain,
    }


def _warps(stages: Sequence[Sequence[Share]]) -> dict[str, Any]:
    """Return how many warps are worth a block, and how many runs of each stage a warp takes of so many."""
    counts = [run_count(stage) for stage in stages]
    return {
        "most": most_warps([stage for stage in stages if stage]),
        "shares": [
            {"warps": w, "runs": [[len(range(rank, count, w)) for rank in range(w)] for count in counts]}
            for w in WARPS
        ],
    }


def _draws(model: ir.Model) -> list[dict[str, Any]]:
    """Return every site that draws: how many words it takes, and when."""
    sites: list[tuple[ir.Site, ir.Dist, tuple[ir.Binder, ...], Span, str]] = []
    sites += [(i.site, i.dist, i.binders, i.span, "start") for i in model.inits]
    for let in model.lets:
        sites.append((let.site, let.dist, () if let.binder is None else (let.binder,), let.span, "step"))
    sites += [(u.site, u.dist, u.binders, u.span, "step") for u in model.updates]
    sites += [(o.site, o.dist, o.binders, o.span, "observation") for o in model.observations]
    policy = model.policy
    if policy is not None:
        sites += [(let.site, let.dist, (), let.span, "policy") for let in policy.lets]
        sites.append((policy.site, policy.dist, policy.binders, policy.span, "policy"))
    return [
        {
            "site": site.path,
            "draws": length_of(tuple(b.type for b in binders)),
            "when": when,
            "line": span.line,
        }
        for site, dist, binders, span, when in sites
        if not isinstance(dist, ir.Certain)
    ]


def _drawings(model: ir.Model) -> list[dict[str, Any]]:
    """Return what pictures show: shapes, for how many members each, and what variables they follow."""
    hidden = {v.name for v in model.variables if not v.visible}
    return [
        {
            "name": drawing.name,
            "shape": drawing.shape,
            "members": length_of(tuple(b.type for b in drawing.binders)),
            "reads": sorted(drawing.reads),
            "believed": bool(drawing.reads & hidden),
            "line": drawing.span.line,
        }
        for drawing in model.drawings
    ]


# Worth and belief ----------------------------------------------------------------------------------


def _interval(t: Type) -> tuple[float | None, float | None]:
    """Return the ends of a number's interval, None where it has none."""
    if not isinstance(t, Int | Float):
        return 0, 1
    low, high = (end if math.isfinite(end) else None for end in (t.low, t.high))
    return low, high


def _rewards(model: ir.Model) -> dict[str, Any]:
    terms = []
    for reward in model.rewards:
        low, high = _interval(reward.value.type)
        members = 1 if reward.binder is None else size_of(reward.binder.type)
        terms.append({"name": reward.name, "members": members, "low": low, "high": high})
    return {
        "low": _total(terms, "low"),
        "high": _total(terms, "high"),
        "fraction_bits": model.reward_bits,
        "terms": terms,
    }


def _total(terms: list[dict[str, Any]], end: str) -> float | None:
    total = 0.0
    for term in terms:
        if term[end] is None:
            return None
        total += term[end] * term["members"]
    return total


def _bound(model: ir.Model, name: str) -> dict[str, Any]:
    value: ir.Expr | None = getattr(model, name)
    if value is None:
        return {"origin": "rollout", "line": None, "low": None, "high": None}
    low, high = _interval(value.type)
    span = model.spans.get(name)
    origin = "derived" if span is None else "declared"
    return {"origin": origin, "line": None if span is None else span.line, "low": low, "high": high}


def _relaxation(model: ir.Model) -> dict[str, Any]:
    """Return the small models whose tables bound the rewards, or what forbids them."""
    found = relax(model)
    return {
        "reason": found.reason or None,
        "holds_declared": found.declared,
        "holds_policy": found.earned,
        "agents_apart": None if found.team is None else found.team.agents,
        "agents_together": found.together or None,
        "groups": [
            {
                "rewards": describe(group),
                "knows": [_known(part) for part in group.parts],
                "states": group.states,
                "actions": len(group.actions),
                "bytes": 4 * group.states,
            }
            for group in found.groups
        ],
    }


def _known(part: Part) -> str:
    if not part.members:
        return part.variable.name
    low = low_of(part.variable.indices[0])
    ends = (f"{low + a}" if a == b else f"{low + a} .. {low + b}" for a, b in runs(part.members))
    return f"{part.variable.name}[{', '.join(ends)}]"


def _policy(model: ir.Model) -> dict[str, Any]:
    policy = model.policy
    return {
        "origin": "uniform" if policy is None else "declared",
        "line": None if policy is None else policy.span.line,
        "history": _block(pack(model).history, model),
    }


def _belief(model: ir.Model) -> dict[str, Any]:
    return {
        "filter": "factored" if model.factored else "particles",
        "seen_first": [init.variable for init in model.first_seen],
        "moved": [v.name for v in model.variables if not v.visible] if redraw.moves_values(model) else [],
        "drawn_when_read": [init.variable for init in redraw.redrawn(model)],
        "factors": [
            {
                "element": factor.element,
                "members": factor.members,
                "variables": list(factor.variables),
                "exact": factor.exact,
                "values": factor.size,
                "inexact": factor.inexact or None,
                "moments": factor.moments is not None and factor.element in model.history.beliefs,
            }
            for factor in model.factors
        ],
        "obstacles": [
            {
                "element": obstacle.element,
                "reason": obstacle.reason,
                "file": obstacle.span.file,
                "line": obstacle.span.line,
                "column": obstacle.span.column,
            }
            for obstacle in model.obstacles
        ],
    }
