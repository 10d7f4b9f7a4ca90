# SPDX-License-Identifier: Apache-2.0
"""Walks over the syntax tree: everything inside a node, and a node with its expressions changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from typing import Any, TypeVar

from hypgen.dsl.syntax import ast

Kind = TypeVar("Kind", bound=ast.Node)
Change = Callable[[ast.Expr], ast.Expr]


def walk(node: ast.Node) -> Iterator[ast.Node]:
    """Yield ``node`` and all nodes in it."""
    yield node
    for f in fields(node):
        yield from _inside(getattr(node, f.name))


def _inside(value: object) -> Iterator[ast.Node]:
    if isinstance(value, ast.Node):
        yield from walk(value)
    elif isinstance(value, tuple):
        for item in value:
            yield from _inside(item)


def map_expressions(node: Kind, change: Change) -> Kind:
    """Return ``node`` with each expression changed that no other inside ``node`` holds; types stay."""
    changes = {f.name: _changed(getattr(node, f.name), change) for f in fields(node) if f.name != "span"}
    return replace(node, **changes)


def _changed(value: Any, change: Change) -> Any:
    if isinstance(value, ast.Expr):
        return change(value)
    if isinstance(value, tuple):
        return tuple(_changed(item, change) for item in value)
    if isinstance(value, ast.Node) and not isinstance(value, ast.TypeExpr):
        return map_expressions(value, change)
    return value
