# SPDX-License-Identifier: Apache-2.0
"""Distributions of floats as C++ that adds them, part by part, to a ``moments::Mixture``."""

from __future__ import annotations

from hypgen.codegen.cpp import masses
from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.tree.expr import method
from hypgen.codegen.tree.statements import Declare, Do, const
from hypgen.dsl import ir


def add_law(dist: ir.Dist, mixture: str, printer: ExprPrinter) -> None:
    """Append what adds a law to ``mixture``, a C++ local."""
    code = printer.code

    def add(law: str, *given: ir.Expr) -> None:
        code.add(Do(method(mixture, law, *printer.exprs(given))))

    match dist:
        case ir.Certain(value=value):
            add("certain", value)
        case ir.Normal(mean=mean, deviation=deviation):
            add("normal", mean, deviation)
        case ir.UniformFloat(low=low, high=high):
            add("uniform", low, high)
        case ir.Exponential(mean=mean):
            add("exponential", mean)
        case ir.Table(entries=entries, rest=rest):
            if masses.is_plain_table(dist, printer.context.model):
                taken = printer.exprs([p for _, p in (entries if rest is not None else entries[:-1])])
            else:
                taken = masses.of_table(dist, printer)
            shares = printer.scope.unique("shares")
            code.add(Declare("moments::Shares", shares))
            for (value, _), mass in zip(entries, taken, strict=False):
                share = printer.scope.unique("share")
                code.add(const("double", share, method(shares, "take", mass)))
                code.add(Do(method(mixture, "certain", printer.expr(value), share)))
            last = entries[-1][0] if rest is None else rest
            code.add(Do(method(mixture, "certain", printer.expr(last), method(shares, "rest"))))
        case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
            with printer.when(printer.expr(condition)):
                add_law(then, mixture, printer)
            with printer.otherwise():
                add_law(otherwise, mixture, printer)
        case ir.LetDist(name=name, value=value, body=body):
            printer.declare(name, value, body)
            add_law(body, mixture, printer)
        case _:
            raise TypeError(f"no mean of {type(dist).__name__}")
