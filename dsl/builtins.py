"""The names that the language itself gives a meaning to."""

from __future__ import annotations

NUMBER_DRAWS = frozenset({"normal", "exponential", "poisson", "binomial"})
DRAWS = NUMBER_DRAWS | {"bernoulli", "uniform", "weighted", "noisy", "truncated", "binned"}
RANGES = frozenset({"clamp", "wrap", "checked"})
HISTORY = frozenset({"last", "belief"})
ROUNDING = frozenset({"floor", "ceil", "round"})
RISING = frozenset({"sqrt", "exp", "log", "log2"})
TRIGONOMETRY = frozenset({"sin", "cos", "tan", "asin", "acos", "atan2"})
FUNCTIONS = (
    ROUNDING | RISING | TRIGONOMETRY | RANGES | {"min", "max", "abs", "sign", "hypot", "value", "at", "index"}
)
QUANTIFIERS = frozenset({"sum", "any", "all", "count", "min", "max", "argmin", "argmax"})
TABLES = frozenset({"distance"})
RESERVED_CALLS = TABLES | DRAWS | HISTORY | FUNCTIONS | QUANTIFIERS
RESERVED_VALUES = frozenset({"gamma", "pi"})
