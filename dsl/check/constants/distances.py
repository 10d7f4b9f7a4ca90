"""``distance(a in T, b in T where linked(a, b): cost else far)``: a table of all-pairs shortest paths."""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING

from hypgen.dsl import ir
from hypgen.dsl.check.constants import constant_entries
from hypgen.dsl.check.terms.quantifiers import bind_types
from hypgen.dsl.ir.evaluate import Value, value_at
from hypgen.dsl.messages.report import mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, FLOAT, INT, PROB, Bool, Enum, Float, Int, Record, Type, size_of
from hypgen.dsl.types.intervals import float32

if TYPE_CHECKING:
    from hypgen.dsl.check.scope.scope import Scope

_MAX_NODES = 1 << 10
_MAX_WORK = 1 << 24  # links followed from all sources: some ten seconds

Links = list[list[tuple[int, Value]]]


def table(
    node: ast.Quantified, scope: Scope, element: Type, indices: tuple[Type, ...], name: str
) -> tuple[Value, ...]:
    """Return the distances between all pairs, row-major: 0 from a value to itself.

    A path's cost is the exact sum of its links' costs, rounded once to the table's type.
    """
    binders = bind_types(node.binders, scope)
    types = tuple(b.type for b in binders)
    if types != indices or len(types) != 2 or types[0] != types[1] or not isinstance(element, Int | Float):
        raise mistake(
            "E0313",
            f"'distance' runs over pairs of a type and gives a table of them, which '{name}' is not",
            node.span,
            "write const d: float[T, T] = distance(a in T, b in T where linked(a, b): cost)",
        )
    if node.where is None:
        raise mistake(
            "E0313",
            "'distance' does not say which values are linked",
            node.span,
            "write distance(a in T, b in T where linked(a, b): cost)",
        )
    count = size_of(types[0])
    if count > _MAX_NODES:
        raise mistake(
            "E0609",
            f"the distances between {count} values take too long to compute",
            node.span,
            f"use a type of {_MAX_NODES} values or fewer, or give the table in a file of params",
        )
    links = _links(node, node.where, binders, scope, element, count)
    if sum(map(len, links)) * count > _MAX_WORK:
        raise mistake(
            "E0609",
            f"the distances along {sum(map(len, links))} links take too long to compute",
            node.span,
            "link each value to its neighbours only, or give the table in a file of params",
        )
    otherwise = None
    if node.otherwise is not None:
        otherwise = constant_entries.scalar(node.otherwise, scope, element, "the value after 'else'").value
    names = [shown(types[0], value_at(types[0], i)) for i in range(count)]
    return tuple(
        _entry(node, distance, otherwise, element, (names[source], names[target]))
        for source in range(count)
        for target, distance in enumerate(_from(source, links))
    )


def _links(
    node: ast.Quantified,
    where: ast.Expr,
    binders: tuple[ir.Binder, ...],
    scope: Scope,
    element: Type,
    count: int,
) -> Links:
    """Return where each value leads and what that costs, by numbers."""
    bound = tuple(zip(node.binders, binders, strict=True))
    linked = list(constant_entries.values(where, bound, scope, BOOL, "the condition after 'where'"))
    links: Links = [[(b, 1) for b in range(count) if b != a and linked[a * count + b]] for a in range(count)]
    if node.body is None:
        return links
    t = INT if isinstance(element, Int) else FLOAT if element == PROB else element
    costs = list(constant_entries.values(node.body, bound, scope, t, "the cost", (where, linked)))
    if min(costs) < 0:
        worst = costs.index(min(costs))
        pair = [shown(binders[0].type, value_at(binders[0].type, x)) for x in divmod(worst, count)]
        raise mistake(
            "E0610",
            f"the cost from {pair[0]} to {pair[1]} is {min(costs):g}",
            node.body.span,
            "shortest paths need costs of 0 or more",
        )
    return [[(b, costs[a * count + b]) for b, _ in targets] for a, targets in enumerate(links)]


def _entry(
    node: ast.Quantified,
    distance: Value | None,
    otherwise: Value | None,
    element: Type,
    pair: tuple[str, str],
) -> Value:
    """Return a distance as a value of the table."""
    if distance is None and otherwise is None:
        raise mistake(
            "E0610",
            f"no way leads from {pair[0]} to {pair[1]}",
            node.span,
            "say how far that is: add 'else value'",
        )
    if distance is None:
        assert otherwise is not None
        return otherwise
    value = float32(distance) if isinstance(element, Float) else distance
    if not constant_entries.fits(value, element):
        raise mistake(
            "E0601",
            f"the distance from {pair[0]} to {pair[1]} is {value:g}, which does not fit {element}",
            node.span,
            "give the table a wider type, such as float or int",
        )
    return value


def shown(t: Type, value: Value) -> str:
    """Return a value of a finite type as the language writes it."""
    match t:
        case Bool():
            return "true" if value else "false"
        case Enum(_, variants):
            for variant in variants:
                offset = int(value) - t.offsets[variant.name]
                if variant.argument is None and offset == 0:
                    return variant.name
                if variant.argument is not None and 0 <= offset < size_of(variant.argument):
                    return f"{variant.name}({shown(variant.argument, value_at(variant.argument, offset))})"
        case Record(name, fields):
            digits = [int(value) // t.stride(n) % size_of(f) for n, f in fields]
            parts = [shown(f, value_at(f, d)) for (_, f), d in zip(fields, digits, strict=True)]
            return f"{name}({', '.join(parts)})"
    return str(value)


def _from(source: int, links: Links) -> list[Value | None]:
    """Return the distances from ``source`` by Dijkstra's algorithm; None where there is no way."""
    found: list[Value | None] = [None] * len(links)
    queue: list[tuple[Value, int]] = [(0, source)]
    while queue:
        distance, node = heapq.heappop(queue)
        if found[node] is not None:
            continue
        found[node] = distance
        for target, cost in links[node]:
            if found[target] is None:
                heapq.heappush(queue, (distance + cost, target))
    return found
