# SPDX-License-Identifier: Apache-2.0
"""Naming values inside expressions and distributions; what is not read is not named."""

from __future__ import annotations

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import walk


def let_in(name: str, value: ir.Expr, body: ir.Expr) -> ir.Expr:
    """Return ``body`` with ``name`` standing for ``value``."""
    return ir.LetIn(body.type, name, value, body) if mentions(body, name) else body


def let_dist(name: str, value: ir.Expr, body: ir.Dist) -> ir.Dist:
    """Return the distribution ``body`` with ``name`` standing for ``value``."""
    if isinstance(body, ir.Certain):
        return ir.Certain(body.type, let_in(name, value, body.value))
    return ir.LetDist(body.type, name, value, body) if mentions(body, name) else body


def mentions(node: ir.Expr | ir.Dist, name: str) -> bool:
    """Return whether the local ``name`` is read in ``node``."""
    return any(isinstance(inner, ir.Local) and inner.name == name for inner in walk(node))
