# SPDX-License-Identifier: Apache-2.0
"""Random laws: normal, exponential, uniform, Poisson, binomial; truncated, clamped, binned, weighted."""

from __future__ import annotations

from support.random_models.expressions import Maker
from support.random_models.sorts import FLOAT, Sort
from support.random_models.tree import Node

ENDS = ((-1.5, 2.0), (0.0, 1.0), (-0.25, 0.25), (3.0, 8.0))
Parts = tuple[str | Node, ...]


def continuous(make: Maker, depth: int) -> Parts:
    """Return a law of floats."""
    if depth > 0 and make.chance(0.25):
        return ("truncated(", *continuous(make, 0), *_ends(make))
    match make.pick("normal", "normal", "exponential", "uniform"):
        case "normal":
            return ("normal(", make.number(depth), ", ", _positive(make), ")")
        case "exponential":
            return ("exponential(", _positive(make), ")")
    low = make.number(depth)
    return ("uniform(", low, ", ", low, " + ", _positive(make), ")")


def sensor(make: Maker, depth: int) -> Parts:
    """Return a law of floats that the agent may see, whatever chooses among its parts."""
    low, high = make.rng.choice(ENDS)
    clamped = make.chance(0.3)

    def one() -> Parts:
        law = continuous(make, depth)
        return ("clamp(", *law, f", {low}, {high})") if clamped else law

    if make.chance(0.5):
        return one()
    return ("(if ", make.truth(depth), " then ", *one(), " else ", *one(), ")")


def _ends(make: Maker) -> Parts:
    """Return the rest of a call, the ends: constants, or one of them above another by what varies."""
    low, high = make.rng.choice(ENDS)
    if make.chance(0.7):
        return (f", {low}, {high})",)
    return (f", {low}, {high} + abs(", make.number(1), "))")


def _positive(make: Maker) -> Node:
    """Return a float above 0, or seldom at 0; it may be large, infinite or no number."""
    if make.chance(0.3):
        return make.node(FLOAT, "(0.25 + abs(", make.number(1), "))")
    value = make.node(FLOAT, "abs(", make.number(1), ")")
    return make.node(FLOAT, "clamp(", value, f", {make.pick('0.0', '0.125', '0.125', '0.125')}, 9.0)")


def counts(make: Maker, sort: Sort, depth: int) -> Parts:
    """Return a law of the ints of a type."""
    ends = f"{sort.low}, {sort.high}"
    kinds = ["uniform", "binomial", "poisson", "binned", "binned"]
    if sort.low >= 0 and sort.high > sort.low:
        kinds.append("truncated")
    mean = ("clamp(", make.number(depth), ", 0.0, 9.0)")
    match make.pick(*kinds):
        case "uniform":
            low = make.leaf(sort)
            if make.chance(0.3):  # far apart, or the wrong way round
                high = ("max(1000, ", make.integer(1), ") - 995")
                return ("clamp(uniform(", make.integer(depth), ", ", *high, f"), {ends})")
            return ("clamp(uniform(", low, " - 1, ", make.leaf(sort), f" + 1), {ends})")
        case "binomial":
            trials = ("clamp(", make.integer(depth - 1), ", 0, 7)")
            return ("clamp(binomial(", *trials, ", clamp(", make.number(1), f", 0, 1)), {ends})")
        case "poisson":
            return ("clamp(poisson(", *mean, f"), {ends})")
        case "binned":
            return ("binned(", *continuous(make, depth), *_ends(make))
    return ("truncated(poisson(", *mean, f"), {ends})")


def weighted(make: Maker, sort: Sort, depth: int, otherwise: Node) -> Parts:
    """Return a law that takes the values of a type by weights."""
    with make.loop(sort) as name:
        where: Parts = (" where ", make.truth(depth)) if make.chance(0.6) else ()
        weight = make.number(depth) if make.chance(0.6) else make.integer(depth)
    return (f"weighted({name} in {sort.text}", *where, ": ", weight, " else ", otherwise, ")")
