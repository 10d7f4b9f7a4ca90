"""Naming values inside expressions and distributions; what is not read is not named."""

from __future__ import annotations

from dataclasses import fields

from hypgen.dsl import ir


def let_in(name: str, value: ir.Expr, body: ir.Expr) -> ir.Expr:
    """Return ``body`` with ``name`` standing for ``value``."""
    return ir.LetIn(body.type, name, value, body) if mentions(body, name) else body


def let_dist(name: str, value: ir.Expr, body: ir.Dist) -> ir.Dist:
    """Return the distribution ``body`` with ``name`` standing for ``value``."""
    if isinstance(body, ir.Certain):
        return ir.Certain(body.type, let_in(name, value, body.value))
    return ir.LetDist(body.type, name, value, body) if mentions(body, name) else body


def mentions(node: object, name: str) -> bool:
    """Return whether the local ``name`` is read in ``node``."""
    if isinstance(node, ir.Local):
        return node.name == name
    if isinstance(node, tuple):
        return any(mentions(part, name) for part in node)
    if isinstance(node, ir.Expr | ir.Dist):
        return any(mentions(getattr(node, f.name), name) for f in fields(node) if f.name != "type")
    return False
