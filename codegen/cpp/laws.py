# SPDX-License-Identifier: Apache-2.0
"""Laws of counts and continuous laws as C++: calls of the runtime's."""

from __future__ import annotations

from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.cpp.text import float32, integer, shifted
from hypgen.dsl import ir
from hypgen.dsl.types import Int, low_of, size_of


def count_text(dist: ir.Counted | ir.UniformInt, drawn: str, suffix: str, printer: ExprPrinter) -> str:
    """Return a call of the sampler (``drawn`` a word) or, with suffix ``_density``, of the density."""
    assert isinstance(dist.type, Int)
    ends = f"{integer(dist.type.low)}, {integer(dist.type.high)}"
    match dist:
        case ir.UniformInt(low=low, high=high):
            texts = f"{printer.text(low)}, {printer.text(high)}"
            return f"dist::uniform_int{suffix}({drawn}, {texts}, {ends})"
        case ir.Poisson(mean=mean):
            law, texts = "poisson", printer.text(mean)
        case ir.Binomial(trials=trials, probability=probability):
            law, texts = "binomial", f"{printer.text(trials)}, {printer.text(probability)}"
        case _:
            raise TypeError(f"no law of counts {type(dist).__name__}")
    limits = "{}" if dist.last is None else f"{{{dist.first}, {dist.last}, true}}"
    return f"dist::{law}{suffix}({drawn}, {texts}, {limits}, {ends})"


def draw_text(law: ir.Continuous, word: str, printer: ExprPrinter) -> str:
    """Return an expression for a draw from a continuous law."""
    if isinstance(law, ir.Clamped):
        return f"math::clamp({draw_text(law.law, word, printer)}, {float32(law.low)}, {float32(law.high)})"
    return f"{law_text(law, printer)}.draw({word})"


def density_text(law: ir.Continuous, value: str, printer: ExprPrinter) -> str:
    """Return an expression for the density of a value of a continuous law."""
    if isinstance(law, ir.Clamped):
        ends = f"{float32(law.low)}, {float32(law.high)}"
        return f"dist::clamped_density({law_text(law.law, printer)}, {ends}, {value})"
    return f"dist::density({law_text(law, printer)}, {value})"


def law_text(law: ir.Continuous, printer: ExprPrinter) -> str:
    """Return an expression for a continuous law."""
    match law:
        case ir.Normal(mean=mean, deviation=deviation):
            return f"dist::Normal{{{printer.text(mean)}, {printer.text(deviation)}}}"
        case ir.UniformFloat(low=low, high=high):
            return f"dist::Uniform{{{printer.text(low)}, {printer.text(high)}}}"
        case ir.Exponential(mean=mean):
            return f"dist::Exponential({printer.text(mean)})"
        case ir.Truncated(law=inner, low=low, high=high):
            return f"dist::Truncated({law_text(inner, printer)}, {printer.text(low)}, {printer.text(high)})"
    raise TypeError(f"no law {type(law).__name__}")


def bin_text(dist: ir.Binned, word: str, printer: ExprPrinter) -> str:
    """Return an expression for the bin that a word draws."""
    return shifted(f"{_bins(dist, printer)}.draw({word})", low_of(dist.type))


def bin_density_text(dist: ir.Binned, value: str, printer: ExprPrinter) -> str:
    """Return an expression for the probability of a bin."""
    return f"{_bins(dist, printer)}.density({shifted(value, -low_of(dist.type))})"


def _bins(dist: ir.Binned, printer: ExprPrinter) -> str:
    ends = f"{printer.text(dist.low)}, {printer.text(dist.high)}"
    return f"dist::Bins({law_text(dist.law, printer)}, {ends}, {size_of(dist.type)})"
