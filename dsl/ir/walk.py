# SPDX-License-Identifier: Apache-2.0
"""Walks over IR: children, rewriting, and when two expressions are the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from functools import cache
from typing import Any, TypeAlias, TypeVar, overload

from hypgen.dsl import ir
from hypgen.dsl.types import BOOL

Node: TypeAlias = ir.Expr | ir.Dist
Kind = TypeVar("Kind", bound=ir.Expr | ir.Dist)
Change: TypeAlias = Callable[[Any], Node]
"""A function from nodes to nodes: an expression for an expression, a distribution for a distribution."""


def children(node: Node) -> Iterator[Node]:
    """Yield the expressions and distributions directly inside ``node``."""
    kind: Any = type(node)
    for name in _attributes(kind):
        yield from _nodes(getattr(node, name))


@cache
def _attributes(kind: Any) -> tuple[str, ...]:
    """Return the fields of a class that may hold nodes: all but the type."""
    return tuple(f.name for f in fields(kind) if f.name not in ("type", "span"))


def _nodes(value: Any) -> Iterator[Node]:
    if isinstance(value, ir.Expr | ir.Dist):
        yield value
    elif isinstance(value, tuple):
        for entry in value:
            yield from _nodes(entry)


def walk(node: Node) -> Iterator[Node]:
    """Yield ``node`` and everything inside it."""
    yield node
    for child in children(node):
        yield from walk(child)


def map_children(node: Kind, change: Change) -> Kind:
    """Return ``node`` with each direct child replaced by ``change(child)``."""
    changes = {}
    for item in fields(node):
        old = getattr(node, item.name)
        new = _map(old, change)
        if new is not old:
            changes[item.name] = new
    return replace(node, **changes) if changes else node


def _map(value: Any, change: Change) -> Any:
    if isinstance(value, ir.Expr | ir.Dist):
        return change(value)
    if isinstance(value, tuple):
        new = tuple(_map(entry, change) for entry in value)
        return value if all(a is b for a, b in zip(new, value, strict=True)) else new
    return value


def bound_names(node: Node) -> tuple[str, ...]:
    """Return the locals that ``node`` introduces for its children."""
    match node:
        case ir.LetIn(name=name) | ir.LetDist(name=name) | ir.DrawIn(name=name):
            return (name,)
        case ir.Quantified(binders=binders) | ir.UniformSet(binders=binders) | ir.Weighted(binders=binders):
            return tuple(b.name for b in binders)
    return ()


def free_locals(node: Node) -> set[str]:
    """Return the names of the locals that ``node`` reads and does not introduce."""
    if isinstance(node, ir.Local):
        return {node.name}
    inside: set[str] = set()
    for child in children(node):
        inside |= free_locals(child)
    return inside - set(bound_names(node))


def shape(value: Any) -> Any:
    """Return a key that is equal for expressions that differ at most in the intervals of their types."""
    if isinstance(value, ir.Expr):
        kind: Any = ir.Clamp if isinstance(value, ir.Checked) else type(value)  # they give the same
        return (kind.__name__, *[shape(getattr(value, name)) for name in _attributes(kind)])
    if isinstance(value, tuple):
        return tuple(shape(entry) for entry in value)
    # 0, 0.0 and False are equal in Python and not in the model.
    return (type(value).__name__, value) if isinstance(value, bool | int | float) else value


class Numbering:
    """Numbers nodes: equal ones have the same number.

    Each object is gone through once. To compare or hash nodes takes longer without bound where a value stands
    in several places, and those in which it stands do too.
    """

    def __init__(self) -> None:
        self._of_objects: dict[int, tuple[Node, int]] = {}  # by id, which the node keeps from being reused
        self._of_contents: dict[Any, int] = {}

    def of(self, node: Node) -> int:
        """Return the number of ``node``."""
        known = self._of_objects.get(id(node))
        if known is None:
            content = (type(node), *(self._part(getattr(node, f.name)) for f in fields(node) if f.compare))
            known = node, self._of_contents.setdefault(content, len(self._of_contents))
            self._of_objects[id(node)] = known
        return known[1]

    def _part(self, value: Any) -> Any:
        if isinstance(value, ir.Expr | ir.Dist):
            return (ir.Expr, self.of(value))
        return tuple(map(self._part, value)) if isinstance(value, tuple) else value


def prime(node: Kind) -> Kind:
    """Return ``node`` reading the next state wherever it reads the state before the step."""
    changed: Any = map_children(node, prime)
    if isinstance(changed, ir.StateRead | ir.LetRead | ir.Call) and not changed.primed:
        changed = replace(changed, primed=True)
    primed: Kind = changed
    return primed


@overload
def substitute(node: ir.Expr, values: Mapping[str, ir.Expr]) -> ir.Expr: ...
@overload
def substitute(node: ir.Dist, values: Mapping[str, ir.Expr]) -> ir.Dist: ...
def substitute(node: Node, values: Mapping[str, ir.Expr]) -> Node:
    """Return ``node`` with locals replaced by expressions whose own locals it does not bind.

    A node that stands in several places, as a value does that was substituted before, is gone through once.
    """
    done: dict[int, Node] = {}

    def replaced(inner: Node) -> Node:
        if isinstance(inner, ir.Local):
            return values.get(inner.name, inner)
        if id(inner) not in done:
            done[id(inner)] = map_children(inner, replaced)
        return done[id(inner)]

    return replaced(node)


def rename_bound(node: Kind, suffix: str) -> Kind:
    """Return ``node`` with ``suffix`` on every local that it introduces, so that none captures another's."""
    bound = {name for inside in walk(node) for name in bound_names(inside)}

    def rename(node: Any) -> Any:
        node = map_children(node, rename)
        match node:
            case ir.Local(name=name) if name in bound:
                return replace(node, name=name + suffix)
            case ir.LetIn(name=name) | ir.LetDist(name=name) | ir.DrawIn(name=name):
                return replace(node, name=name + suffix)
            case (
                ir.Quantified(binders=binders) | ir.UniformSet(binders=binders) | ir.Weighted(binders=binders)
            ):
                return replace(node, binders=tuple(ir.Binder(b.name + suffix, b.type) for b in binders))
        return node

    renamed: Kind = rename(node)
    return renamed


def negated(condition: ir.Expr) -> ir.Expr:
    """Return ``not condition``."""
    if isinstance(condition, ir.Unary) and condition.op == "not":
        return condition.operand
    return ir.Unary(BOOL, "not", condition)
