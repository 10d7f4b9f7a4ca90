# SPDX-License-Identifier: Apache-2.0
"""Distributions of the intermediate representation that numbers make: counts, ranges and weights.

R(x) = floor(x * 2^32 + 0.5) clamped to [0, 2^32] (NaN gives 0) is the number of words that a cumulative
probability x, a double, takes.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.dsl.ir.nodes import Binder, Dist, Expr


@dataclass(frozen=True)
class Widened(Dist):
    """What ``dist`` draws, an int, over a range with more values. Density: 0 outside ``dist``'s own range."""

    dist: Dist


@dataclass(frozen=True)
class UniformInt(Dist):
    """Every int from ``low`` to ``high`` alike, then clamped into the node's type.

    With n = max(high - low + 1, 1) the int low + ((w * n) >> 32). Density: the share of these n ints that the
    clamp takes to the value, double(count) / double(n).
    """

    low: Expr
    high: Expr


@dataclass(frozen=True)
class Counted(Dist):
    """A law of counts k = 0, 1, .., given by masses m_k: doubles, each computed from the one before.

    With ``last`` (truncated) only first .. last can occur: s_k = m_first + .. + m_k, added in this order, and
    S = s_last. Otherwise ``first`` is 0 and S = 1. C_k = R(s_k / S) words give at most k. The node's type,
    low .. high, is clamped into: the draw is the first k of low .. high - 1 with w < C_k, or else high.
    Density: C_k - C_(k-1) words over 2^32, where C_(low-1) = 0 and C_high = 2^32.
    """

    first: int
    last: int | None


@dataclass(frozen=True)
class Poisson(Counted):
    """m_0 = e^-mean and m_(k+1) = m_k * (mean / (k + 1)), with ``mean`` clamped to 0 .. 690 (NaN gives 0).

    e^-mean is the fixed sequence exp2(double(mean) * -1.4426950408889634).
    """

    mean: Expr


@dataclass(frozen=True)
class Binomial(Counted):
    """How many of n ``trials`` succeed, each with ``probability`` p, clamped to 0 .. 1 (NaN gives 0).

    For p <= 1/2, q = 1 - p: m_0 = q^n (by squaring, from the lowest bit of n) and
    m_(k+1) = (m_k * ((n - k) / (k + 1))) * (p / q), in doubles; C_k = 2^32 from k = n on, and where n <= low.
    For larger p the failures are counted: with the masses m' of probability 1 - p, of which those from
    n - last to n - first can occur, C_k = 2^32 - C'_(n-k-1).
    """

    trials: Expr
    probability: Expr


@dataclass(frozen=True)
class Weighted(Dist):
    """A value of the one binder, with probability in proportion to ``weight``, a float.

    A match has ``condition`` true and a weight above 0. S is the sum, from 0, of the matches' weights as
    doubles, and c = (2^63 * (1 - 2^-32)) / S. Each match has the mass trunc(double(weight) * c), 0 if that is
    not finite: it is the first with W < the sum of the masses up to it. What all leave of 2^63 goes to the
    likeliest, the first with the largest weight. Without a match ``otherwise`` is drawn from the same word
    (without it, the binder's first value). Density: the masses that give the value, over 2^63.
    """

    binders: tuple[Binder, ...]
    condition: Expr | None
    weight: Expr
    otherwise: Dist | None


# Continuous laws ---------------------------------------------------------------------------------
#
# Their type is a float. F(x), in double, is the probability below x; u stands for (double(w) + 0.5) * 2^-32.
#
# The density of a float x, in double, is per unit of x: it may be above 1. E(y) is exp2(y) by its fixed
# sequence, 0 unless y >= -1000. A law without width has a point that it always draws: its density is 1 for
# the point, else 0. An x that is no number has density 0.


@dataclass(frozen=True)
class Continuous(Dist):
    """Base of continuous laws."""


@dataclass(frozen=True)
class Normal(Continuous):
    """mean + deviation * float(normal_of_word(w)); the deviation's sign does not matter.

    F(x) = normal_cdf(z), z = (x - double(mean)) / s, s = |double(deviation)|. Density:
    E(z * z * -0.7213475204444817) * 0.3989422804014327 / s. Unless s > 0, the point is the mean.
    """

    mean: Expr
    deviation: Expr


@dataclass(frozen=True)
class UniformFloat(Continuous):
    """min(low + (high - low) * float(u), high).

    F(x) = (x - double(low)) / (double(high) - double(low)), clamped to 0 .. 1; where not high > low, 1 if
    x > high, else 0. Density: 1 / (double(high) - double(low)) where low <= x <= high, else 0. Unless
    high > low, the point is high.
    """

    low: Expr
    high: Expr


@dataclass(frozen=True)
class Exponential(Continuous):
    """m * float(exponential_of_word(w)), where m is the mean, or 0 if that is not above 0.

    F(x) = 1 - S(x), S(x) = exp2(x / double(m) * -1.4426950408889634), its exponent not below -1000; S(x) = 1
    unless x > 0. If m is 0, F(x) is 1 for x > 0, else 0. Density: E(x / double(m) * -1.4426950408889634) / m
    where x >= 0, else 0. If m is 0, the point is 0.
    """

    mean: Expr


@dataclass(frozen=True)
class Truncated(Continuous):
    """``law``, a ``Normal`` or ``Exponential``, given that it lies in low .. high.

    In double, P(x) is the law's probability from low to x, computed in the smaller tail: of a normal law
    cdf(b) - cdf(a) with a = (low - mean) / |deviation| and b = (x - mean) / |deviation|, or cdf(-a) - cdf(-b)
    if a > 0; of an exponential law S(low) - S(x). The draw is the x with P(x) = p = u * P(high):
    mean + |deviation| * float(normal_quantile(cdf(a) + p)), or, if a > 0,
    mean - |deviation| * float(normal_quantile(cdf(-a) - p)); m * float(-log(S(low) - p)); then low unless
    x > low, and high if x > high. Where not P(high) > 0 it is the end nearer to the mean (to 0 for an
    exponential law): low if that lies above it, else high. F(x) = P(x) / P(high), 0 for x <= low, 1 for
    x >= high; without a P(high), 1 for x above the end that is drawn, else 0. Density: the law's over P(high)
    where low <= x <= high, else 0. Without a P(high) the point is the end that is drawn, otherwise the law's.
    """

    law: Continuous
    low: Expr
    high: Expr


@dataclass(frozen=True)
class Clamped(Continuous):
    """What ``law``, which is not ``Clamped``, draws, clamped into [low, high]; NaN stays NaN.

    Density: the law's where low < x < high. An end has a probability: F(low), and what the law has above high
    (normal_cdf(-z), S(x), or 1 - F(high)). Outside of the ends it is 0. Where low = high or the law has a
    point, the point is clamped.
    """

    law: Continuous
    low: float
    high: float


@dataclass(frozen=True)
class Binned(Dist):
    """The bin, of the n values of the int ``type``, into which ``law`` falls; the end bins take the tails.

    Bin i ends below e = double(low) + width * ((i + 1) / n), where width is double(high) - double(low), or 0
    unless high > low. C_i = R(F(e)), the last's is 2^32: the first bin with w < C_i.
    Density: max(C_i - C_(i-1), 0) words over 2^32.
    """

    law: Continuous
    low: Expr
    high: Expr
