# SPDX-License-Identifier: Apache-2.0
"""Walks through trees of C++: what stands in them, and trees with parts in the place of others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from hypgen.codegen.tree.expr import Expr, Index, Literal, Member, Name, Operation, Postfix, Prefix
from hypgen.codegen.tree.statements import Block, Declare, Function, walk


def nodes(expr: Expr) -> Iterator[Expr]:
    """Yield an expression and all that it consists of."""
    yield expr
    for child in expr.children:
        yield from nodes(child)


def all_nodes(block: Block) -> Iterator[Expr]:
    """Yield all expressions of a block, and those that they consist of."""
    for statement in walk(block):
        for expr in statement.expressions:
            yield from nodes(expr)


def root(expr: Expr) -> str | None:
    """Return the variable that an expression is a part of, or points into; None if it is no such part."""
    match expr:
        case Name(text):
            return text
        case Member(owner=inner) | Index(array=inner) | Prefix(operand=inner) | Postfix(operand=inner):
            return root(inner)
        case Operation(left=inner, sign="+"):
            return root(inner)
    return None


def declared(block: Block) -> set[str]:
    """Return the names that a block declares for what stands behind in it."""
    return {statement.name for statement in block if isinstance(statement, Declare)}


def mapped(value: Any, change: Callable[[Expr], Expr | None]) -> Any:
    """Return a tree with what ``change`` gives in the place of expressions, where it gives anything."""
    if isinstance(value, Expr) and (found := change(value)) is not None:
        return found
    if isinstance(value, list | tuple):
        entries = [mapped(entry, change) for entry in value]
        same = all(new is old for new, old in zip(entries, value, strict=True))
        return value if same else type(value)(entries)
    if is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: getattr(value, f.name) for f in fields(value)}
        new = {name: mapped(part, change) for name, part in parts.items()}
        changed = {name: part for name, part in new.items() if part is not parts[name]}
        return replace(value, **changed) if changed else value
    return value


def with_values(block: Block, values: Mapping[str, Expr]) -> Block:
    """Return a block with expressions in the place of variables."""

    def change(expr: Expr) -> Expr | None:
        return values.get(expr.text) if isinstance(expr, Name) else None

    return [mapped(statement, change) for statement in block]


def integer(expr: Expr) -> int | None:
    """Return the value of an integer literal."""
    if isinstance(expr, Literal) and expr.text.lstrip("-").isdigit():
        return int(expr.text)
    return None


def calls(functions: Sequence[Function], roots: set[str]) -> set[str]:
    """Return the functions that can be reached from ``roots``, by name."""
    called = {f.name: {n for s in walk(f.body) for n in s.names} for f in functions}
    found, left = set[str](), [name for name in roots if name in called]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += [n for n in called[name] if n in called]
    return found
