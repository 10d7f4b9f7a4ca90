# SPDX-License-Identifier: Apache-2.0
"""Functions that differ in numbers alone, as one template over these numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from os.path import commonprefix

from hypgen.codegen.tree.expr import Expr, Literal, Name, Operation
from hypgen.codegen.tree.statements import Block, For, Function, walk
from hypgen.codegen.tree.walks import integer, mapped

Values = tuple[int, ...]


@dataclass(frozen=True)
class Instance:
    """What stands for a function: a template and its arguments."""

    name: str
    values: Values


def share(
    functions: Sequence[Function], unique: Callable[[str], str]
) -> tuple[list[Function], dict[str, Instance]]:
    """Return functions of which none differ in numbers alone, and what stands for those that did.

    ``unique`` makes the name of a template.
    """
    alike: dict[str, list[Function]] = {}
    for function in functions:
        alike.setdefault(repr(_with_numbers(function, lambda n, value: Literal("#"))), []).append(function)
    found, instances = list[Function](), dict[str, Instance]()
    for some in alike.values():
        if len(some) == 1 or len(some[0].body) == 1:  # a line says as much as the template's head
            found += some
            continue
        name = unique(commonprefix([f.name for f in some]).rstrip("_"))
        template, values = _template(some, name)
        found.append(template)
        instances |= {f.name: Instance(name, v) for f, v in zip(some, values, strict=True)}
    return [renamed(f, instances) for f in found], instances


def renamed(function: Function, instances: Mapping[str, Instance]) -> Function:
    """Return a function that uses what stands for others."""

    def change(expr: Expr) -> Expr | None:
        if not isinstance(expr, Name) or expr.text not in instances:
            return None
        instance = instances[expr.text]
        return Name(instance.name, (*expr.given, *map(str, instance.values)))

    return replace(function, body=mapped(function.body, change)) if instances else function


def _template(some: Sequence[Function], name: str) -> tuple[Function, list[Values]]:
    """Return a template and the arguments that make it each of ``some``."""
    numbers = [_numbers(function) for function in some]
    columns = [*zip(*numbers, strict=True)]
    differing = [*dict.fromkeys(c for c in columns if len({*c}) > 1)]
    names = _names(some[0], columns, differing)
    differing.sort(key=lambda column: names[column])

    def change(n: int, value: int) -> Expr | None:
        return Name(names[columns[n]]) if columns[n] in names else None

    values = [tuple(column[i] for column in differing) for i in range(len(some))]
    comments = [
        f"// <{', '.join(map(str, v))}>: {line.removeprefix('// ')}"
        for f, v in zip(some, values, strict=True)
        for line in f.comment
    ]
    if len({f.comment for f in some}) == 1:
        comments = [*some[0].comment]
    template = (*some[0].template, *(f"int {names[column]}" for column in differing))
    body = _with_numbers(some[0], change).body
    return replace(some[0], name=name, body=body, comment=tuple(comments), template=template), values


def _names(function: Function, columns: Sequence[Values], differing: Sequence[Values]) -> dict[Values, str]:
    """Return names of numbers: ``first`` and ``last`` of the loop that they limit, or else ``entry``."""
    taken = {n for s in walk(function.body) for e in s.expressions for n in e.names}
    limits = _limits(function)
    found: dict[Values, str] = {}
    for column in differing:
        base = next((limits[n] for n, c in enumerate(columns) if c == column and n in limits), "entry")
        name, n = base, 2
        while name in taken:
            name, n = f"{base}_{n}", n + 1
        taken.add(name)
        found[column] = name
    return found


def _limits(function: Function) -> dict[int, str]:
    """Return names of the numbers that limit loops, by their place among all numbers."""
    limits: dict[int, str] = {}
    for statement in walk(function.body):
        if isinstance(statement, For) and isinstance(statement.test, Operation):
            ends = [statement.first, statement.test.right]
            for name, end in zip(("first", "last"), sorted(ends, key=lambda e: integer(e) or 0), strict=True):
                limits[id(end)] = name
    places: dict[int, str] = {}
    n = -1
    for expr in _in_order(function.body):
        if integer(expr) is not None:
            n += 1
            if id(expr) in limits:
                places[n] = limits[id(expr)]
    return places


def _in_order(body: Block) -> Iterator[Expr]:
    """Yield expressions in the order in which ``mapped`` meets them."""
    met: list[Expr] = []

    def visit(expr: Expr) -> Expr | None:
        met.append(expr)
        return None

    mapped(body, visit)
    return iter(met)


def _numbers(function: Function) -> list[int]:
    found: list[int] = []

    def change(n: int, value: int) -> Expr | None:
        found.append(value)
        return None

    _with_numbers(function, change)
    return found


def _with_numbers(function: Function, change: Callable[[int, int], Expr | None]) -> Function:
    """Return a function with other expressions for its numbers, which ``change`` is given in order."""
    n = -1

    def visit(expr: Expr) -> Expr | None:
        nonlocal n
        value = integer(expr)
        if value is None:
            return None
        n += 1
        return change(n, value)

    return replace(function, name="", comment=(), body=mapped(function.body, visit))
