# SPDX-License-Identifier: Apache-2.0
"""What calls and lets stand for: their bodies, in the terms of those who call or read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import overload

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Kind, Node, prime, rename_bound, substitute


@overload
def applied(body: ir.Expr, formals: Iterable[str], arguments: Sequence[ir.Expr], primed: bool) -> ir.Expr: ...
@overload
def applied(body: ir.Dist, formals: Iterable[str], arguments: Sequence[ir.Expr], primed: bool) -> ir.Dist: ...
def applied(body: Node, formals: Iterable[str], arguments: Sequence[ir.Expr], primed: bool) -> Node:
    """Return ``body`` with arguments for its formals; ``primed`` reads the next state in it, not in them.

    ``body`` binds no local that an argument reads: an ``Inliner`` renames what it binds.
    """
    values = dict(zip(formals, arguments, strict=True))
    return substitute(prime(body) if primed else body, values)


def certain(node: Node) -> ir.Expr | None:
    """Return an expression, or a distribution that draws nothing, as an expression; None for a draw."""
    match node:
        case ir.Expr():
            return node
        case ir.Certain(value=value):
            return value
        case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
            a, b = certain(then), certain(otherwise)
            return None if a is None or b is None else ir.If(node.type, condition, a, b)
        case ir.LetDist(name=name, value=value, body=body):
            inner = certain(body)
            return None if inner is None else ir.LetIn(node.type, name, value, inner)
    return None


class Inliner:
    """Puts the bodies of functions and lets in the place of calls and reads.

    Every body gets names of its own for the locals that it binds: ``mark`` and a number follow the old name.
    ``functions`` and ``lets`` may change meanwhile.
    """

    def __init__(
        self, functions: Mapping[str, ir.Function], lets: Mapping[str, ir.Let], mark: str = "_"
    ) -> None:
        self._functions = functions
        self._lets = lets
        self._mark = mark
        self._count = 0

    def call(self, node: ir.Call) -> ir.Expr:
        """Return what a call stands for."""
        function = self._functions[node.function]
        names = [f.name for f in function.formals]
        return applied(self._renamed(function.body), names, node.arguments, node.primed)

    def let(self, node: ir.LetRead) -> Node:
        """Return what the read of a let stands for: the distribution of a let that draws."""
        let = self._lets[node.let]
        body = let.dist.value if isinstance(let.dist, ir.Certain) else let.dist
        names = [] if let.binder is None else [let.binder.name]
        return applied(self._renamed(body), names, node.indices, node.primed)

    def _renamed(self, body: Kind) -> Kind:
        self._count += 1
        return rename_bound(body, f"{self._mark}{self._count}")


@overload
def unnamed(node: ir.LetIn) -> ir.Expr: ...
@overload
def unnamed(node: ir.LetDist) -> ir.Dist: ...
def unnamed(node: ir.LetIn | ir.LetDist) -> Node:
    """Return the body of a local let with the value wherever it has the name."""
    return substitute(node.body, {node.name: node.value})
