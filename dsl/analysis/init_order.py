# SPDX-License-Identifier: Apache-2.0
"""The order of inits: each after those that it reads, and a family member by member where that is needed.

A member may read members of its own family that come before it, where the text shows that they do: through
the index ``j`` under a condition ``j < i``, or ``i - 1``, with ``i`` the member's own index.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.stages import Edges, find_cycle
from hypgen.dsl.analysis.uses import Uses
from hypgen.dsl.ir.order import dependencies_first
from hypgen.dsl.ir.walk import children, rename_bound, substitute
from hypgen.dsl.messages import e04_variables
from hypgen.dsl.messages.report import Mistake, Report

_LESS = {"lt": (0, 1), "gt": (1, 0)}
_NOT_LESS = {"ge": (0, 1), "le": (1, 0)}

Pairs: TypeAlias = frozenset[tuple[str, str]]


@dataclass(frozen=True)
class Definitions:
    """What an init's expressions may go through to state."""

    lets: Mapping[str, ir.Let]
    functions: Mapping[str, ir.Function]
    families: frozenset[str]


def order_inits(
    inits: Sequence[ir.Assign],
    variables: Mapping[str, ir.Variable],
    definitions: Definitions,
    uses: Uses,
    report: Report,
) -> tuple[ir.Assign, ...]:
    """Return the inits, each after those that it reads, with their ``group``.

    Those of visible variables come first, unless one of them reads hidden state.
    """
    of = {i.variable: i for i in inits}
    edges: Edges = {
        i.variable: {
            r.name: r
            for r in reversed(uses.closure(Owner("init", i.variable)))
            if r.kind == "variable" and r.name in of
        }
        for i in inits
    }
    order: list[ir.Assign] = []
    for names in _components(edges):
        inside = {n: {m: r for m, r in edges[n].items() if m in names} for n in names}
        if not any(inside.values()):
            order.append(of[names[0]])
            continue
        family = len(names) == 1 or _family(names, variables, definitions)
        where = {n: _places(of[n], variables, definitions) if family else {} for n in names}
        unproven = [(n, m) for n in names for m in inside[n] if "any" in where[n].get(m, {"any"})]
        if unproven and family:
            report.add(_unproven(*unproven[0], inside))
            return tuple(inits)
        same = {n: {m: r for m, r in inside[n].items() if "own" in where[n].get(m, {"own"})} for n in names}
        cycle = find_cycle(same)
        if cycle:
            report.add(_cyclic(cycle, same))
            return tuple(inits)
        group = names[0] if len(names) > 1 else None
        order += [replace(of[n], group=group) for n in dependencies_first(same)]
    visible = {n for n in of if variables[n].visible}
    if any(edges[n].keys() - visible for n in visible):
        return tuple(order)
    return tuple(sorted(order, key=lambda i: i.variable not in visible))


def _components(edges: Edges) -> list[list[str]]:
    """Return the variables that need each other as lists, each list after those that it reads (Tarjan)."""
    number: dict[str, int] = {}
    lowest: dict[str, int] = {}
    open_: list[str] = []
    found: list[list[str]] = []

    def visit(name: str) -> None:
        number[name] = lowest[name] = len(number)
        open_.append(name)
        for other in edges[name]:
            if other not in number:
                visit(other)
                lowest[name] = min(lowest[name], lowest[other])
            elif other in open_:
                lowest[name] = min(lowest[name], number[other])
        if lowest[name] == number[name]:
            start = open_.index(name)
            part = set(open_[start:])
            del open_[start:]
            found.append([n for n in edges if n in part])

    for name in edges:
        if name not in number:
            visit(name)
    return found


def _family(names: list[str], variables: Mapping[str, ir.Variable], definitions: Definitions) -> bool:
    """Return whether the variables are all of one family."""
    owners = {variables[n].element for n in names}
    return len(owners) == 1 and owners <= definitions.families


def _places(
    init: ir.Assign, variables: Mapping[str, ir.Variable], definitions: Definitions
) -> dict[str, set[str]]:
    """Return, for each variable of the init's own element, which members' are read: own, lower or any."""
    if not init.binders:
        return {}
    own = init.binders[0].name
    found: dict[str, set[str]] = {}
    for read, below in _reads(init.dist, {}, frozenset(), definitions):
        if variables[read.variable].element == variables[init.variable].element:
            found.setdefault(read.variable, set()).add(_place(read.indices[0], own, below))
    return found


def _place(index: ir.Expr, own: str, below: Pairs) -> str:
    match index:
        case ir.Local(_, name) if name == own:
            return "own"
        case ir.Local(_, name) if (name, own) in below:
            return "lower"
        case ir.Binary(_, "sub", ir.Local(_, name), ir.Const(_, value)) if name == own and value > 0:
            return "lower"
    return "any"


def _reads(
    node: ir.Expr | ir.Dist, values: dict[str, ir.Expr], below: Pairs, definitions: Definitions
) -> Iterator[tuple[ir.StateRead, Pairs]]:
    """Yield all reads of state, through calls and lets, with the pairs of locals known to be in order.

    ``values`` are what the locals of the body stand for, in the init's own locals. ``ir.reads`` keeps neither
    the conditions around a read nor what stands for the locals in its indices.
    """
    match node:
        case ir.StateRead():
            indices = tuple(substitute(i, values) for i in node.indices)
            yield replace(node, indices=indices), below
        case ir.Call(_, name, arguments):
            function = definitions.functions.get(name)
            if function is not None:
                names = [f.name for f in function.formals]
                given = {n: substitute(a, values) for n, a in zip(names, arguments, strict=True)}
                body = rename_bound(function.body, f" of {name}")
                yield from _reads(body, given, below, definitions)
        case ir.LetRead(_, name, indices):
            let = definitions.lets.get(name)
            if let is not None:
                given = {} if let.binder is None else {let.binder.name: substitute(indices[0], values)}
                yield from _reads(rename_bound(let.dist, f" of {name}"), given, below, definitions)
        case ir.LetIn(_, name, value, body) | ir.LetDist(_, name, value, body):
            yield from _reads(value, values, below, definitions)
            yield from _reads(body, {**values, name: substitute(value, values)}, below, definitions)
            return
        case ir.If(_, condition, then, otherwise) | ir.IfDist(_, condition, then, otherwise):
            yield from _reads(condition, values, below, definitions)
            yield from _reads(then, values, below | _ordered(condition, True, values), definitions)
            yield from _reads(otherwise, values, below | _ordered(condition, False, values), definitions)
            return
        case ir.Binary(_, "and" | "or" as op, left, right):
            yield from _reads(left, values, below, definitions)
            yield from _reads(right, values, below | _ordered(left, op == "and", values), definitions)
            return
        case ir.Quantified(_, _, _, condition, body, otherwise) if condition is not None:
            inner = below | _ordered(condition, True, values)
            yield from _reads(condition, values, below, definitions)
            if body is not None:
                yield from _reads(body, values, inner, definitions)
            if otherwise is not None:
                yield from _reads(otherwise, values, below, definitions)
            return
        case ir.UniformSet(_, _, condition, value, rest) | ir.Weighted(_, _, condition, value, rest) if (
            condition is not None
        ):
            yield from _reads(condition, values, below, definitions)
            yield from _reads(value, values, below | _ordered(condition, True, values), definitions)
            if rest is not None:
                yield from _reads(rest, values, below, definitions)
            return
    for child in children(node):
        yield from _reads(child, values, below, definitions)


def _ordered(condition: ir.Expr, holds: bool, values: dict[str, ir.Expr]) -> Pairs:
    """Return the pairs (j, i) of locals for which ``condition``, or its opposite, shows j < i."""
    match condition:
        case ir.Unary(_, "not", operand):
            return _ordered(operand, not holds, values)
        case ir.Binary(_, "and" | "or" as op, left, right) if holds == (op == "and"):
            return _ordered(left, holds, values) | _ordered(right, holds, values)
        case ir.Binary(_, op, left, right) if op in (_LESS if holds else _NOT_LESS):
            sides = [substitute(left, values), substitute(right, values)]
            low, high = (sides[i] for i in (_LESS if holds else _NOT_LESS)[op])
            if isinstance(low, ir.Local) and isinstance(high, ir.Local):
                return frozenset({(low.name, high.name)})
    return frozenset()


def _unproven(name: str, other: str, edges: Edges) -> Mistake:
    reach = edges[name][other]
    read = reach.path[-1].span if len(reach.path) > 1 else None
    return Mistake(e04_variables.unordered_inits(name, other, reach.span, read))


def _cyclic(cycle: list[str], edges: Edges) -> Mistake:
    reads = [edges[a][b] for a, b in zip(cycle, [*cycle[1:], cycle[0]], strict=True)]
    places = [r.path[-1].span for r in reads]
    return Mistake(e04_variables.circular_inits(cycle, reads[0].span, places))
