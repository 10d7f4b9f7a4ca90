# SPDX-License-Identifier: Apache-2.0
"""Laws of counts and continuous laws as C++: calls of the runtime's."""

from __future__ import annotations

from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.cpp.text import float32
from hypgen.codegen.tree.expr import TRUE, Expr, Literal, Operand, braces, call, shifted
from hypgen.dsl import ir
from hypgen.dsl.types import Int, is_finite, low_of, size_of


def count(dist: ir.Counted | ir.UniformInt, drawn: Operand, suffix: str, printer: ExprPrinter) -> Expr:
    """Return a call of the sampler (``drawn`` a word) or, with suffix ``_density``, of the density."""
    assert isinstance(dist.type, Int)
    ends = dist.type.low, dist.type.high
    match dist:
        case ir.UniformInt(low=low, high=high):
            given = printer.exprs((low, high))
            return call(f"dist::uniform_int{suffix}", drawn, *given, *ends)
        case ir.Poisson(mean=mean):
            law, given = "poisson", [printer.expr(mean)]
        case ir.Binomial(trials=trials, probability=probability):
            law, given = "binomial", printer.exprs((trials, probability))
        case _:
            raise TypeError(f"no law of counts {type(dist).__name__}")
    limits = braces("") if dist.last is None else braces("", int(dist.first), int(dist.last), TRUE)
    return call(f"dist::{law}{suffix}", drawn, *given, limits, *ends)


def draw(law: ir.Continuous, word: Expr, printer: ExprPrinter) -> Expr:
    """Return an expression for a draw from a continuous law."""
    if isinstance(law, ir.Clamped):
        return call("math::clamp", draw(law.law, word, printer), *_ends(law))
    return law_of(law, printer).call("draw", word)


def density(law: ir.Continuous, value: Operand, printer: ExprPrinter) -> Expr:
    """Return an expression for the density of a value of a continuous law."""
    if isinstance(law, ir.Clamped):
        return call("dist::clamped_density", law_of(law.law, printer), *_ends(law), value)
    return call("dist::density", law_of(law, printer), value)


def _ends(law: ir.Clamped) -> tuple[Expr, Expr]:
    return Literal(float32(law.low)), Literal(float32(law.high))


def law_of(law: ir.Continuous, printer: ExprPrinter) -> Expr:
    """Return an expression for a continuous law."""
    match law:
        case ir.Normal(mean=mean, deviation=deviation):
            recurs = "Recurring" if _has_finite_states(printer.context.model) else ""
            return braces(f"dist::{recurs}Normal", *printer.exprs((mean, deviation)))
        case ir.UniformFloat(low=low, high=high):
            return braces("dist::Uniform", *printer.exprs((low, high)))
        case ir.Exponential(mean=mean):
            return call("dist::Exponential", printer.expr(mean))
        case ir.Truncated(law=inner, low=low, high=high):
            return call("dist::Truncated", law_of(inner, printer), *printer.exprs((low, high)))
    raise TypeError(f"no law {type(law).__name__}")


def _has_finite_states(model: ir.Model) -> bool:
    """Return whether there are finitely many states, so that a law's parameters recur."""
    return all(is_finite(v.type) for v in model.variables)


def bin_drawn(dist: ir.Binned, word: Expr, printer: ExprPrinter) -> Expr:
    """Return an expression for the bin that a word draws."""
    return shifted(_bins(dist, printer).call("draw", word), low_of(dist.type))


def bin_density(dist: ir.Binned, value: Operand, printer: ExprPrinter) -> Expr:
    """Return an expression for the probability of a bin."""
    return _bins(dist, printer).call("density", shifted(value, -low_of(dist.type)))


def _bins(dist: ir.Binned, printer: ExprPrinter) -> Expr:
    ends = printer.exprs((dist.low, dist.high))
    return call("dist::Bins", law_of(dist.law, printer), *ends, size_of(dist.type))
