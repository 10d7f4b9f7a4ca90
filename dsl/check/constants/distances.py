# SPDX-License-Identifier: Apache-2.0
"""``distance(a in T, b in T where linked(a, b): cost else far)``: a table of all-pairs shortest paths."""

from __future__ import annotations

import heapq

from hypgen.dsl import ir
from hypgen.dsl.check.constants import constant_entries
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.terms.quantifiers import bind_types
from hypgen.dsl.ir.evaluate import Value, value_at
from hypgen.dsl.messages import e03_units, e06_ranges
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, FLOAT, INT, PROB, Bool, Enum, Float, Int, Record, Type, size_of
from hypgen.dsl.types.intervals import float32

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
        raise Mistake(e03_units.distance_of_other(name, node.span))
    if node.where is None:
        raise Mistake(e03_units.distance_without_links(node.span))
    count = size_of(types[0])
    if count > _MAX_NODES:
        raise Mistake(e06_ranges.many_nodes(count, _MAX_NODES, node.span))
    links = _links(node, node.where, binders, scope, element, count)
    if sum(map(len, links)) * count > _MAX_WORK:
        raise Mistake(e06_ranges.many_links(sum(map(len, links)), node.span))
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
        start, end = (shown(binders[0].type, value_at(binders[0].type, x)) for x in divmod(worst, count))
        raise Mistake(e06_ranges.negative_cost(start, end, min(costs), node.body.span))
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
        raise Mistake(e06_ranges.no_way(*pair, node.span))
    if distance is None:
        assert otherwise is not None
        return otherwise
    value = float32(distance) if isinstance(element, Float) else distance
    if not constant_entries.fits(value, element):
        raise Mistake(e06_ranges.distance_outside_range(*pair, value, element, node.span))
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
