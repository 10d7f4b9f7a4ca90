# SPDX-License-Identifier: Apache-2.0
"""Distributions whose values lie in a table: the word gives a position in it, and no branch is taken.

They stand for ``ir.Table`` and ``ir.UniformSet`` where ``tabulate`` has found that all values fit in a table.
"""

from __future__ import annotations

from hypgen.codegen.layout.nodes import POSITION, UniformPick, WeightedPick
from hypgen.dsl import ir
from hypgen.dsl.ir import masses
from hypgen.dsl.ir.walk import rename_bound, substitute
from hypgen.dsl.types import BOOL, Bool, Int, size_of


def weighted(dist: ir.Table) -> WeightedPick | None:
    """Return ``dist`` as a pick, its value a choice by position.

    None where a weight is no constant, or one of which words do not tell the mass.
    """
    if not masses.in_words(dist):
        return None
    probabilities = tuple(p for _, p in dist.entries)
    values = [v for v, _ in dist.entries]
    if dist.rest is None:
        probabilities = probabilities[:-1]
    else:
        values.append(dist.rest)
    constants = tuple(p for p in probabilities if isinstance(p, ir.Const))
    if len(constants) < len(probabilities) or len(values) < 3:
        return None
    position_type = Int(0, len(values) - 1)
    choice = values[-1]
    for number in reversed(range(len(values) - 1)):
        at = _equal(ir.Local(position_type, POSITION), ir.Const(position_type, number))
        choice = ir.If(dist.type, at, values[number], choice)
    return WeightedPick(dist.type, constants, choice)


def uniform(dist: ir.UniformSet) -> UniformPick | None:
    """Return ``dist`` as a pick among its matches; where nothing matches, what stands in is the one value."""
    condition, otherwise = dist.condition, dist.otherwise
    if condition is None or len(dist.binders) != 1 or isinstance(dist.binders[0].type, Bool):
        return None
    binder = dist.binders[0]
    size = size_of(binder.type)
    count = ir.Quantified(Int(0, size), "count", (binder,), condition, None, None)
    # The match at a position is the one with as many matches before it.
    match, before = (ir.Local(binder.type, f"{binder.name}_{role}") for role in ("match", "before"))
    earlier = ir.Quantified(
        Int(0, size),
        "count",
        (ir.Binder(before.name, before.type),),
        _and(_for(condition, binder, before), ir.Binary(BOOL, "lt", before, match)),
        None,
        None,
    )
    at = _equal(earlier, ir.Local(Int(0, size - 1), POSITION))
    found = ir.Quantified(
        binder.type,
        "argmin",
        (ir.Binder(match.name, match.type),),
        _and(_for(condition, binder, match), at),
        ir.Const(Int(0, 0), 0),
        None,
    )
    value: ir.Expr = ir.LetIn(dist.type, binder.name, found, dist.value)
    if otherwise is not None:
        if not isinstance(otherwise, ir.Certain):
            return None
        nothing = _equal(rename_bound(count, "_counted"), ir.Const(Int(0, size), 0))
        value = ir.If(dist.type, nothing, otherwise.value, value)
    least = ir.Binary(Int(1, size), "max", count, ir.Const(Int(1, 1), 1))
    return UniformPick(dist.type, least, value)


def _for(condition: ir.Expr, binder: ir.Binder, local: ir.Local) -> ir.Expr:
    return substitute(rename_bound(condition, local.name), {binder.name: local})


def _and(left: ir.Expr, right: ir.Expr) -> ir.Expr:
    return ir.Binary(BOOL, "and", left, right)


def _equal(left: ir.Expr, right: ir.Expr) -> ir.Expr:
    return ir.Binary(BOOL, "eq", left, right)
