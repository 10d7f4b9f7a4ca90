# SPDX-License-Identifier: Apache-2.0
"""How the language's own functions and draws are called, and what each gives."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Form:
    """``calls`` are the ways to call it, ``gives`` says what comes of it."""

    calls: tuple[str, ...]
    gives: str

    def __str__(self) -> str:
        return " or ".join(self.calls)


def _form(*calls: str, gives: str) -> Form:
    return Form(calls, gives)


FORMS = {
    "abs": _form("abs(x)", gives="the size of a number, without its sign"),
    "acos": _form("acos(x)", gives="the angle with this cosine, in radians"),
    "all": _form("all(i in T: condition)", gives="whether a condition holds for all"),
    "any": _form("any(i in T: condition)", gives="whether a condition holds for at least one"),
    "argmax": _form("argmax(i in T where c: x)", gives="the first i with the largest x"),
    "argmin": _form("argmin(i in T where c: x)", gives="the first i with the least x"),
    "asin": _form("asin(x)", gives="the angle with this sine, in radians"),
    "at": _form("at(array, i, j, default)", gives="an entry, or the default where an index is out of range"),
    "atan2": _form("atan2(y, x)", gives="the angle of a direction, in radians"),
    "belief": _form("belief(e)", gives="the agent's probability of a condition, or mean of a number"),
    "bernoulli": _form("bernoulli(p)", gives="a draw: true with probability p"),
    "binned": _form("binned(draw, low, high)", gives="a draw of a number, put into the bins of an int range"),
    "binomial": _form("binomial(n, p)", gives="a draw: how many of n tries succeed"),
    "cdf": _form("cdf(draw, x)", gives="the probability that a continuous draw is below x"),
    "ceil": _form("ceil(x)", gives="the least int that is not below x"),
    "checked": _form("checked(x)", "checked(x, low, high)", gives="x, which the author knows to be in range"),
    "clamp": _form(
        "clamp(x)", "clamp(x, low, high)", gives="the nearest value in range; of a draw, what it gives then"
    ),
    "cos": _form("cos(x)", gives="the cosine of an angle in radians"),
    "count": _form("count(i in T: condition)", gives="for how many a condition holds"),
    "deviation": _form("deviation(x)", gives="the standard deviation of a number in the agent's belief"),
    "distance": _form(
        "distance(a in T, b in T where linked: cost else far)",
        gives="a table of the shortest ways",
    ),
    "exp": _form("exp(x)", gives="e to the power of x"),
    "exponential": _form("exponential(mean)", gives="a draw above 0 with this mean"),
    "floor": _form("floor(x)", gives="the largest int that is not above x"),
    "hypot": _form("hypot(x, y)", gives="the length of a vector"),
    "index": _form("index(v)", gives="the number of an enum's value, from 0"),
    "last": _form("last(x, first)", gives="what was done or seen in the step before; first before any step"),
    "log": _form("log(x)", gives="the natural logarithm"),
    "log2": _form("log2(x)", gives="the logarithm to base 2"),
    "max": _form("max(a, b)", "max(i in T where c: x)", gives="the largest of some numbers"),
    "min": _form("min(a, b)", "min(i in T where c: x)", gives="the least of some numbers"),
    "noisy": _form("noisy(value, p)", gives="a draw: the value with probability p, else another one"),
    "normal": _form("normal(mean, sd)", gives="a draw of a float around a mean"),
    "poisson": _form("poisson(mean)", gives="a draw of a count with this mean"),
    "round": _form("round(x)", gives="the nearest int"),
    "sign": _form("sign(x)", gives="-1, 0 or 1"),
    "sin": _form("sin(x)", gives="the sine of an angle in radians"),
    "sqrt": _form("sqrt(x)", gives="the square root"),
    "sum": _form("sum(i in T where c: x)", gives="the sum over all that fulfil a condition"),
    "tan": _form("tan(x)", gives="the tangent of an angle in radians"),
    "truncated": _form("truncated(draw, low, high)", gives="a draw, given that it is in range"),
    "uniform": _form(
        *("uniform(T)", "uniform(low, high)", "uniform(i in T where c: x)"),
        gives="a draw: all values alike",
    ),
    "value": _form("value(x)", gives="the number without its unit"),
    "weighted": _form("weighted(i in T: weight)", gives="a draw: each i as its weight says"),
    "wrap": _form("wrap(x)", "wrap(x, low, high)", gives="x, led around at the ends of a range"),
}
"""By name, all that can be called."""

VALUES = {
    "gamma": "gamma  # the discount of a step",
    "pi": "pi  # half of a full turn, in radians",
}
"""By name, the language's own values, each with what it is."""
