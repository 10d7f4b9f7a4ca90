"""Random distributions over the types of random models."""

from __future__ import annotations

from random_expressions import Maker
from random_sorts import BOOL, FLOAT, Sort
from random_tree import Node

TABLES = (("0.25",), ("0.125", "0.5"), ("0.25", "0.75"), ("0.5", "0.25", "0.25"), ("0.1", "0.2", "0.3"))


def draw(make: Maker, sort: Sort, depth: int) -> Node:
    """Return a distribution over a type."""

    def node(*parts: str | Node) -> Node:
        return Node(f"draw of {sort.text}", sort.plain, parts)

    kinds = ["certain", "fields", "fields"]
    if sort != make.types.vec:
        kinds = ["certain", "table", "table"]
    if sort.finite:
        kinds += ["noisy", "uniform", "set", "set", "weighted"]
    if sort == FLOAT:
        kinds += ["law", "law"]
    if sort.kind == "int":
        kinds += ["count", "bins", "ends"]
    if depth > 0:
        kinds += ["if", "let", "match"]
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
        case "set":
            return _set(make, sort, depth)
        case "weighted":
            return _weighted(make, sort, depth)
        case "law":
            return (
                node("clamp(", _law(make, depth), ", -2.0, 3.5)") if make.chance(0.3) else _law(make, depth)
            )
        case "count":
            return _count(make, sort, depth)
        case "bins":
            return node("binned(", _law(make, depth), ", -1.0, ", "1.0 + abs(", make.number(1), "))")
        case "ends":
            return node("clamp(uniform(", make.integer(depth), ", max(1000, ", make.integer(1), ") - 995))")
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
    value = make.of(make.types.small, depth)
    with make.bound(make.types.small) as name:
        return node(f"(let {name} = ", value, " in ", draw(make, sort, depth - 1), ")")


def _law(make: Maker, depth: int) -> Node:
    """Return a continuous law, whose parameters may degenerate in some states."""
    a, b = make.number(depth), make.number(1)
    normal, waiting = ("normal(", a, ", 0.25 + abs(", b, "))"), ("exponential(0.25 + abs(", a, "))")
    base: tuple[str | Node, ...] = normal if make.chance(0.6) else waiting
    if make.chance(0.3):
        base = ("uniform(", a, ", 1.0 + abs(", b, "))")
    if make.chance(0.4):
        base = ("truncated(", *base, ", 0.5, 1.0 + abs(", make.number(0), "))")
    return Node("draw of float", FLOAT.plain, base)


def _count(make: Maker, sort: Sort, depth: int) -> Node:
    """Return a law of counts: clamped into an int type, or truncated first."""
    law: tuple[str | Node, ...] = ("poisson(2.0 * abs(", make.number(depth), "))")
    if make.chance(0.6):
        trials = ("clamp(", make.integer(depth), ", 0, 6), clamp(", make.number(1), ", 0, 1)")
        law = ("binomial(6 - ", *trials, ")") if make.chance(0.3) else ("binomial(", *trials, ")")
    if make.chance(0.3):
        law = ("truncated(", *law, ", 0, 5)")
    return Node(f"draw of {sort.text}", sort.plain, ("clamp(", *law, ")"))


def _weighted(make: Maker, sort: Sort, depth: int) -> Node:
    with make.bound(sort) as name:
        where: list[str | Node] = [" where ", make.truth(depth)] if make.chance(0.5) else []
        weight = make.number(depth)
    parts = (f"weighted({name} in {sort.text}", *where, ": abs(", weight, ") else ")
    return Node(f"draw of {sort.text}", sort.plain, (*parts, draw(make, sort, 0), ")"))


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
    over = make.rng.choice(make.types.finite)
    with make.bound(over) as name:
        where: list[str | Node] = [" where ", make.truth(depth)] if make.chance(0.8) else []
        value = make.of(sort, depth)
    rest: list[str | Node] = []
    if where and make.chance(0.8):
        rest = [" else ", draw(make, sort, 0)]
    return Node(
        f"draw of {sort.text}",
        sort.plain,
        (f"uniform({name} in {over.text}", *where, ": ", value, *rest, ")"),
    )
