# SPDX-License-Identifier: Apache-2.0
"""Random draws within draws: named ones, entries of tables, arguments, operands and conditions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from support.random_models.expressions import Maker
from support.random_models.sorts import BOOL, Sort
from support.random_models.tree import Node

TABLES = (("0.25",), ("0.125", "0.5"), ("0.25", "0.75"), ("0.5", "0.25", "0.25"), ("0.1", "0.2", "0.3"))
Draw = Callable[[Maker, Sort, int], Node]


def nested(make: Maker, sort: Sort, depth: int, kind: str, draw: Draw) -> Node:
    """Return a draw of a type with draws inside; ``draw`` makes these."""
    parts: list[str | Node]
    match kind:
        case "drawn":
            first = make.rng.choice([BOOL, make.types.small, make.types.mode])
            with _summed(make, first):
                law = draw(make, first, depth - 1)
                with make.bound(first) as name:
                    parts = [f"(let {name}: {first.text} ~ ", law, " in ", draw(make, sort, depth - 1), ")"]
        case "mixture":
            weights = make.rng.choice(TABLES)
            parts = ["{"]
            for weight in weights:
                parts += [draw(make, sort, depth - 1), f": {weight}, "]
            if sum(map(float, weights)) < 0.999:
                parts += ["else ", draw(make, sort, depth - 1)]
            parts.append("}")
        case "condition":
            with _summed(make, BOOL):
                parts = ["(if ", draw(make, BOOL, depth - 1), " then ", draw(make, sort, depth - 1)]
                parts += [" else ", make.of(sort, depth - 1), ")"]
        case _:
            parts = _arguments(make, sort, depth, draw)
    return Node(f"draw of {sort.text}", sort.plain, tuple(parts))


def _arguments(make: Maker, sort: Sort, depth: int, draw: Draw) -> list[str | Node]:
    """Return a call or an operator of draws."""
    functions = [f for f in make.reach.functions if f.sort == sort and f.argument.finite]
    if functions and make.chance(0.7):
        function = make.rng.choice(functions)
        with _summed(make, function.argument):
            return [f"{function.name}(", draw(make, function.argument, depth - 1), ")"]
    if sort.kind == "record" and all(part is not None and part.finite for _, part in sort.parts):
        listed: list[str | Node] = []
        for _, part in sort.parts:
            assert part is not None
            with _summed(make, part):
                listed += [", ", draw(make, part, depth - 1)]
        return [f"{sort.text}(", *listed[1:], ")"]
    if sort.kind == "enum":
        choices = [(n, part) for n, part in sort.parts if part is not None and part.finite]
        if choices:
            name, part = make.rng.choice(choices)
            assert part is not None
            return [f"{name}(", draw(make, part, depth - 1), ")"]
    small = make.types.small
    parts: tuple[str | Node, ...]
    with _summed(make, small):
        parts = (f"uniform({small.text})",)
        if make.chance(0.5):
            parts = ("{", make.leaf(small), ": 0.25, else ", make.leaf(small), "}")
        drawn = Node(f"draw of {small.text}", small.plain, parts)
        if sort.kind == "int":
            op = make.pick("+", "-", "*")
            return ["clamp(", make.integer(0), f" {op} ", drawn, f", {sort.low}, {sort.high})"]
        return [
            "(if ",
            make.integer(0),
            " < ",
            drawn,
            " then ",
            make.of(sort, 0),
            " else ",
            make.of(sort, 0),
            ")",
        ]


@contextmanager
def _summed(make: Maker, sort: Sort) -> Iterator[None]:
    """Count the values of a draw: a density goes through them."""
    make.rounds *= sort.size
    yield
    make.rounds //= sort.size
