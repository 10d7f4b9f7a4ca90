# SPDX-License-Identifier: Apache-2.0
"""Expressions with functions inlined and comprehensions over one type written out."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

from hypgen.dsl import ir
from hypgen.dsl.ir.evaluate import decided
from hypgen.dsl.ir.inline import Inliner, certain, unnamed
from hypgen.dsl.ir.walk import children, map_children, substitute
from hypgen.dsl.types import BOOL, Float, Type, low_of, size_of

_MOST_NODES = 1 << 16  # of one expression; as many take a second


class TooLarge(Exception):
    """An expression has too many nodes once it is written out."""


class Flattener:
    """Writes expressions out: without calls, lets, ``LetIn`` and comprehensions over ``unrolled``."""

    def __init__(self, model: ir.Model, unrolled: Type) -> None:
        lets = {let.name: let for let in model.lets}
        self._inliner = Inliner({f.name: f for f in model.functions}, lets)
        self._unrolled = unrolled
        self._nodes = 0

    def of(self, node: ir.Expr | ir.Dist, values: Mapping[str, ir.Expr]) -> ir.Expr | None:
        """Return ``node`` with these values of locals; None where it draws. Raises ``TooLarge``."""
        self._nodes = 0
        found = certain(node)
        return None if found is None else self._flat(substitute(found, values))

    def _flat(self, e: ir.Expr) -> ir.Expr:
        self._nodes += 1
        if self._nodes > _MOST_NODES:
            raise TooLarge
        match e:
            case ir.Call():
                return self._flat(self._inliner.call(e))
            case ir.LetRead():
                value = certain(self._inliner.let(e))
                if value is not None:
                    return self._flat(value)
            case ir.LetIn():
                return self._flat(unnamed(e))
            case ir.Quantified(binders=(binder,)) if binder.type == self._unrolled:
                if (out := _written_out(e)) is not None:
                    return self._flat(out)
        return _simpler(map_children(e, self._flat))


def conjuncts(e: ir.Expr) -> list[ir.Expr]:
    """Return the conditions that ``e`` is the conjunction of."""
    if isinstance(e, ir.Binary) and e.op == "and":
        return [*conjuncts(e.left), *conjuncts(e.right)]
    return [e]


def conjunction(parts: list[ir.Expr]) -> ir.Expr:
    """Return the condition that all parts hold."""
    return reduce(lambda a, b: ir.Binary(BOOL, "and", a, b), parts) if parts else ir.Const(BOOL, True)


def _written_out(e: ir.Quantified) -> ir.Expr | None:
    """Return a comprehension over one binder as operators, if its kind has one."""
    op, binder = {"any": "or", "all": "and", "sum": "add"}.get(e.kind), e.binders[0]
    if op is None or e.body is None:
        return None
    terms: list[ir.Expr] = []
    for position in range(size_of(binder.type)):
        value: dict[str, ir.Expr] = {binder.name: ir.Const(binder.type, position + low_of(binder.type))}
        body = substitute(e.body, value)
        terms.append(body if e.condition is None else _where(e, substitute(e.condition, value), body))
    return reduce(lambda a, b: ir.Binary(e.type, op, a, b), terms)


def _where(e: ir.Quantified, where: ir.Expr, body: ir.Expr) -> ir.Expr:
    """Return a term of a comprehension that counts only where a condition holds."""
    if e.kind == "sum":
        return ir.If(e.type, where, body, ir.Const(e.type, 0.0 if isinstance(e.type, Float) else 0))
    if e.kind == "all":
        return ir.Binary(BOOL, "or", ir.Unary(BOOL, "not", where), body)
    return ir.Binary(BOOL, "and", where, body)


def _simpler(e: ir.Expr) -> ir.Expr:
    """Return what the constants among the operands leave of ``e``."""
    parts = list(children(e))
    if parts and all(isinstance(part, ir.Const) for part in parts):
        value = decided(e, lambda _: None)
        return e if value is None or isinstance(value, float) else ir.Const(e.type, value)
    match e:
        case (
            ir.Binary(op="and" | "or" as op, left=ir.Const(value=value), right=other)
            | ir.Binary(op="and" | "or" as op, left=other, right=ir.Const(value=value))
        ):
            return ir.Const(BOOL, value) if value == (op == "or") else other
        case ir.If(condition=ir.Const(value=value), then=then, otherwise=otherwise):
            return then if value else otherwise
    return e
