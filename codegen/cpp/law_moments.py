# SPDX-License-Identifier: Apache-2.0
"""Distributions of floats as C++ that adds them, part by part, to a ``moments::Mixture``."""

from __future__ import annotations

from hypgen.codegen.cpp import masses
from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.dsl import ir


def add_law(dist: ir.Dist, mixture: str, printer: ExprPrinter) -> None:
    """Append what adds a law to ``mixture``, a C++ local."""
    code = printer.code
    match dist:
        case ir.Certain(value=value):
            code.add(f"{mixture}.certain({printer.text(value)});")
        case ir.Normal(mean=mean, deviation=deviation):
            code.add(f"{mixture}.normal({printer.text(mean)}, {printer.text(deviation)});")
        case ir.UniformFloat(low=low, high=high):
            code.add(f"{mixture}.uniform({printer.text(low)}, {printer.text(high)});")
        case ir.Exponential(mean=mean):
            code.add(f"{mixture}.exponential({printer.text(mean)});")
        case ir.Table(entries=entries, rest=rest):
            if masses.is_plain_table(dist, printer.context.model):
                taken = [printer.text(p) for _, p in (entries if rest is not None else entries[:-1])]
            else:
                taken = masses.table_texts(dist, printer)
            shares = printer.scope.unique("shares")
            code.add(f"moments::Shares {shares};")
            for (value, _), mass in zip(entries, taken, strict=False):
                share = printer.scope.unique("share")
                code.add(f"const double {share} = {shares}.take({mass});")
                code.add(f"{mixture}.certain({printer.text(value)}, {share});")
            last = entries[-1][0] if rest is None else rest
            code.add(f"{mixture}.certain({printer.text(last)}, {shares}.rest());")
        case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
            with printer.block(f"if ({printer.text(condition)})"):
                add_law(then, mixture, printer)
            with printer.block("else"):
                add_law(otherwise, mixture, printer)
        case ir.LetDist(name=name, value=value, body=body):
            printer.declare(name, value, body)
            add_law(body, mixture, printer)
        case _:
            raise TypeError(f"no mean of {type(dist).__name__}")
