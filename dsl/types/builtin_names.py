# SPDX-License-Identifier: Apache-2.0
"""The names that the language itself gives a meaning to."""

from __future__ import annotations

NUMBER_DRAWS = frozenset({"normal", "exponential", "poisson", "binomial"})
DRAWS = NUMBER_DRAWS | {"bernoulli", "uniform", "weighted", "noisy", "truncated", "binned"}
RANGES = frozenset({"clamp", "wrap", "checked"})
BELIEFS = frozenset({"belief", "deviation"})
HISTORY = BELIEFS | {"last"}
ROUNDING = frozenset({"floor", "ceil", "round"})
RISING = frozenset({"sqrt", "exp", "log", "log2"})
TRIGONOMETRY = frozenset({"sin", "cos", "tan", "asin", "acos", "atan2"})
FUNCTIONS = (
    ROUNDING | RISING | TRIGONOMETRY | RANGES | {"min", "max", "abs", "sign", "hypot", "value", "at", "index"}
)
QUANTIFIERS = frozenset({"sum", "any", "all", "count", "min", "max", "argmin", "argmax"})
TABLES = frozenset({"distance"})
CUMULATIVE = frozenset({"cdf"})
RESERVED_CALLS = CUMULATIVE | TABLES | DRAWS | HISTORY | FUNCTIONS | QUANTIFIERS
RESERVED_VALUES = frozenset({"gamma", "pi"})
# What other languages call it, and how it is written here.
FOREIGN_TYPES = {
    **dict.fromkeys(("real", "double", "number"), "float"),
    **dict.fromkeys(("integer", "long", "uint"), "low .. high, or int where nothing is stored"),
    "boolean": "bool",
    "probability": "prob",
    **dict.fromkeys(("string", "str"), "enum Name { first, second } and the type Name"),
}
FOREIGN_FUNCTIONS = {
    "gaussian": "normal(mean, sd)",
    **dict.fromkeys(("dirac", "deterministic"), "the value alone, which is drawn for certain"),
    "gauss": "normal(mean, sd)",
    "categorical": "a table, { a: 0.6, b: 0.3, else c }",
    "discrete": "a table, { a: 0.6, b: 0.3, else c }",
    "multinomial": "a table, { a: 0.6, b: 0.3, else c }",
    "choice": "uniform(Type), or a table, { a: 0.6, else b }",
    "random": "uniform(0.0, 1.0), as a draw",
    "rand": "uniform(0.0, 1.0), as a draw",
    "randint": "uniform(low, high), as a draw",
    "flip": "bernoulli(p), as a draw",
    "pow": "x ** y",
    "ln": "log(x)",
    "norm": "hypot(x, y)",
    "mod": "a % b",
    "atan": "atan2(y, x)",
    "arctan2": "atan2(y, x)",
    "forall": "all(i in Type: condition)",
    "exists": "any(i in Type: condition)",
}
