# SPDX-License-Identifier: Apache-2.0
"""Probabilities in C++: as float32 where a 32-bit word is enough to compare with, else as masses."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.tree.expr import Expr, Literal, braces, call, member, of
from hypgen.codegen.tree.statements import Declare, Do
from hypgen.dsl import ir
from hypgen.dsl.ir import masses
from hypgen.dsl.ir.walk import walk
from hypgen.dsl.types import Float

PART = 1 << 45  # the least mass of another than a noisy value that whole words are split for


def is_plain(probability: ir.Expr, complement: ir.Expr | None, model: ir.Model) -> bool:
    """Return whether the float32 tells the mass, surely a whole number of words."""
    return complement is None and masses.is_plain(probability, _least(probability, model))


def is_plain_table(dist: ir.Table, model: ir.Model) -> bool:
    """Return whether all masses are so, and the last value takes what the others leave."""
    if masses.of_table(dist) is not None:
        return masses.in_words(dist)
    if not all(is_plain(p, q, model) for _, p, q in with_complements(dist)):
        return False
    return dist.rest is not None or _least(dist.entries[-1][1], model) * masses.WHOLE >= masses.RARE


def with_complements(dist: ir.Table) -> list[tuple[ir.Expr, ir.Expr, ir.Expr | None]]:
    """Return the entries of a table that is no table of constants: value, probability and complement."""
    complements: Sequence[ir.Expr | None] = dist.complements or (None,) * len(dist.entries)
    return [(value, p, q) for (value, p), q in zip(dist.entries, complements, strict=True)]


def argument(probability: ir.Expr, complement: ir.Expr | None, printer: ExprPrinter) -> Expr:
    """Return a probability as an argument of a sampler or density: its mass, unless it is plain."""
    if is_plain(probability, complement, printer.context.model):
        return printer.expr(probability)
    return mass(probability, complement, printer)


def mass(probability: ir.Expr, complement: ir.Expr | None, printer: ExprPrinter) -> Expr:
    """Return the mass of a probability. One that is made of params alone is computed when they are loaded."""
    if isinstance(probability, ir.Const):
        return literal(masses.of_constant(probability))
    parts = (probability,) if complement is None else (probability, complement)
    found = call("dist::mass", *map(printer.expr, parts))
    read = {node.param: None for part in parts for node in walk(part) if isinstance(node, ir.ParamRead)}
    if not read or not all(_reads_only_params(part, printer.context.model) for part in parts):
        return found
    fields = printer.context.masses
    if found not in fields:
        fields[found] = printer.names.derived_table("_".join((*read, "mass")))
    return member("params", fields[found])


def of_table(dist: ir.Table, printer: ExprPrinter) -> list[Expr]:
    """Return the masses of all entries but the last value, of a table that is not plain."""
    constant = masses.of_table(dist)
    if constant is not None:
        return [literal(mass) for mass in constant[:-1]]
    found = [mass(p, q, printer) for _, p, q in with_complements(dist)]
    model = printer.context.model
    if dist.rest is not None:
        return found
    if _least(dist.entries[-1][1], model) * masses.WHOLE >= masses.RARE:
        return found[:-1]
    array = printer.scope.unique("masses")
    printer.code.add(Declare("std::uint64_t", array, braces("", *found), ("",)))
    printer.code.add(Do(call("dist::settle", array)))
    return [of(array)[i] for i in range(len(found) - 1)]


def leaves(probability: ir.Expr) -> int:
    """Return what a probability leaves of the whole, at least."""
    if isinstance(probability, ir.Const):
        return masses.WHOLE - masses.of_constant(probability)
    high = probability.type.high if isinstance(probability.type, Float) else 1.0
    return masses.WHOLE - masses.rounded(high)


def literal(mass: int) -> Expr:
    """Return a mass as C++."""
    return braces("std::uint64_t", Literal(f"0x{mass:016X}"))


def _reads_only_params(e: ir.Expr, model: ir.Model) -> bool:
    """Return whether a probability is the same in all draws: arithmetic of params that are no arrays."""
    params = {p.name for p in model.params if not p.indices}
    return all(
        node.param in params
        if isinstance(node, ir.ParamRead)
        else isinstance(node, ir.Const | ir.Unary | ir.Binary | ir.Clamp)
        for node in walk(e)
    )


def _least(probability: ir.Expr, model: ir.Model) -> float:
    """Return what a probability is at least; 0 where nothing is known."""
    if isinstance(probability, ir.Call):
        [body] = [f.body for f in model.functions if f.name == probability.function]
        return max(_least(body, model), _low(probability))
    return _low(probability)


def _low(e: ir.Expr) -> float:
    return e.type.low if isinstance(e.type, Float) else 0.0
