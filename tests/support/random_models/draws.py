# SPDX-License-Identifier: Apache-2.0
"""Random distributions over the types of random models."""

from __future__ import annotations

from support.random_models.expressions import Maker
from support.random_models.laws import continuous, counts, weighted
from support.random_models.nested_draws import TABLES, nested
from support.random_models.sorts import BOOL, FLOAT, Sort
from support.random_models.tree import Node


def draw(make: Maker, sort: Sort, depth: int) -> Node:
    """Return a distribution over a type."""

    def node(*parts: str | Node) -> Node:
        return Node(f"draw of {sort.text}", sort.plain, parts)

    kinds = ["certain", "fields", "fields"]
    if sort != make.types.vec:
        kinds = ["certain", "table", "table"]
    if sort.finite:
        kinds += ["noisy", "uniform", "set", "set"]
    if sort.finite and make.fits(sort):
        kinds.append("weighted")
    if sort.kind == "int":
        kinds += ["counts", "counts"]
    if sort.kind in ("float", "prob"):
        kinds += ["continuous", "continuous"]
    if any(f.law and f.sort == sort for f in make.reach.functions):
        kinds += ["named", "named"]
    if depth > 0:
        kinds += ["if", "let", "match"]
    if depth > 0 and sort != make.types.vec:  # a draw would decide both fields
        kinds += ["drawn", "mixture", "argument", "condition"]
    match make.pick(*kinds):
        case "certain":
            return node(make.of(sort, depth))
        case "fields":  # of floats: each is a draw of its own
            return node("Vec(", draw(make, FLOAT, depth - 1), ", ", draw(make, FLOAT, depth - 1), ")")
        case "table":
            return _table(make, sort, depth)
        case "noisy":
            return node("noisy(", make.of(sort, depth), ", clamp(", make.number(1), ", 0, 1))")
        case "uniform" if sort == BOOL:
            return node("bernoulli(clamp(", make.number(depth), ", 0, 1))")
        case "uniform":
            return node(f"uniform({sort.text})")
        case "counts":
            return node(*counts(make, sort, depth))
        case "continuous" if sort.kind == "prob" or make.chance(0.2):
            return node("clamp(", *continuous(make, depth), ", 0, 1)")
        case "continuous":
            return node(*continuous(make, depth))
        case "weighted":
            return node(*weighted(make, sort, depth, draw(make, sort, 0)))
        case "named":
            law = make.rng.choice([f for f in make.reach.functions if f.law and f.sort == sort])
            return node(f"{law.name}(", make.of(law.argument, depth - 1), ")")
        case "set":
            return _set(make, sort, depth)
        case "if":
            parts = (make.truth(depth), " then ", draw(make, sort, depth - 1))
            return node("(if ", *parts, " else ", draw(make, sort, depth - 1), ")")
        case "match":
            with make.bound(make.types.small) as name:
                far = draw(make, sort, depth - 1)
            mode = make.of(make.types.mode, depth - 1)
            return node(
                "(match ", mode, f" {{ far({name}) => ", far, ", else => ", draw(make, sort, depth - 1), " })"
            )
        case "drawn" | "mixture" | "argument" | "condition" as kind:
            return nested(make, sort, depth, kind, draw)
    value = make.of(make.types.small, depth)
    with make.bound(make.types.small) as name:
        return node(f"(let {name} = ", value, " in ", draw(make, sort, depth - 1), ")")


def _table(make: Maker, sort: Sort, depth: int) -> Node:
    weights = make.rng.choice(TABLES)
    parts: list[str | Node] = ["{"]
    for weight in weights:
        parts += [make.of(sort, depth), f": {weight}, "]
    total = sum(map(float, weights))
    if total < 0.999:
        parts += ["else ", make.of(sort, depth)]
    return Node(f"draw of {sort.text}", sort.plain, (*parts, "}"))


def _set(make: Maker, sort: Sort, depth: int) -> Node:
    over = make.rng.choice([s for s in make.types.finite if make.fits(s)] or [BOOL])
    with make.loop(over) as name:
        where: list[str | Node] = [" where ", make.truth(depth)] if make.chance(0.8) else []
        value = make.of(sort, depth)
    rest: list[str | Node] = []
    if where and make.chance(0.95):  # without it, a set that is surely empty is refused
        rest = [" else ", draw(make, sort, 0)]
    return Node(
        f"draw of {sort.text}",
        sort.plain,
        (f"uniform({name} in {over.text}", *where, ": ", value, *rest, ")"),
    )
