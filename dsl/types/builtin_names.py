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
    **dict.fromkeys(("float", "float32", "float64", "real", "double", "number"), "float"),
    **dict.fromkeys(
        ("int", "int32", "int64", "integer", "long", "uint", "unsigned", "size_t"),
        "low .. high, or int where nothing is stored",
    ),
    **dict.fromkeys(("bool", "boolean", "logical"), "bool"),
    **dict.fromkeys(
        ("list", "array", "vector", "matrix", "dict", "map", "tuple", "set"),
        "T[I], an array of T over the index type I, or a record",
    ),
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
    **dict.fromkeys(
        ("random", "rand", "runif"), "uniform(0.0, 1.0), or uniform(Type) for a value of it, as a draw"
    ),
    **dict.fromkeys(("sparsecat", "sparse_cat"), "a table, { a: 0.6, b: 0.3, else c }"),
    **dict.fromkeys(("randn", "rnorm"), "normal(0.0, 1.0), as a draw"),
    "krondelta": "the value alone, which is drawn for certain",
    **dict.fromkeys(("len", "length", "size", "card", "numel"), "count(i in Type), how many values it has"),
    **dict.fromkeys(("square", "sqr"), "x ** 2"),
    **dict.fromkeys(("to_int", "trunc", "int_floor", "as_integer"), "floor(x), ceil(x) or round(x)"),
    **dict.fromkeys(("log10", "log1p"), "log(x), as in log(x) / log(10)"),
    **dict.fromkeys(("copy", "clone", "deepcopy"), "the value alone: nothing is shared"),
    **dict.fromkeys(("fabs", "norm1"), "abs(x)"),
    **dict.fromkeys(("if_else", "ifelse", "where"), "if condition then a else b"),
    **dict.fromkeys(("mean", "average", "avg"), "sum(i in Type: e) / count(i in Type)"),
    **dict.fromkeys(
        ("sorted", "reversed", "range", "enumerate", "zip"), "[i in Type: e], an array over a type"
    ),
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
FOREIGN_VALUES = {
    **dict.fromkeys(
        ("None", "null", "nil", "nullptr", "NULL"),
        "a variant of your own, as in enum Seen { nothing, .. }",
    ),
    **dict.fromkeys(("this", "self"), "the variable's name alone: it is this element's"),
    **dict.fromkeys(("inf", "Inf", "infinity", "INFINITY"), "a large number: values are finite"),
    **dict.fromkeys(("nan", "NaN"), "a number of your own: values are finite"),
    "end": "the number of the last index",
}
