# SPDX-License-Identifier: Apache-2.0
"""What is tuned: ranges of the solver's options and of the model's params."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.types import Bool, Enum, Float, Int
from hypgen.experiments.suite import Value

if TYPE_CHECKING:
    from optuna.trial import Trial

_LOGARITHMIC = 20  # ends that differ by so large a factor are searched on a logarithmic scale


class TuningError(ValueError):
    """What cannot be tuned; the text says why and what would do."""


@dataclass(frozen=True)
class Range:
    """Numbers from ``low`` to ``high``, both included."""

    low: float
    high: float
    whole: bool = False

    @property
    def is_logarithmic(self) -> bool:
        """Whether the range is searched on a logarithmic scale."""
        return self.low > 0 and self.high / self.low >= _LOGARITHMIC

    def suggest(self, trial: Trial, name: str) -> Value:
        """Return a value that the sampler suggests; one with a fraction has four digits."""
        log = self.is_logarithmic
        if self.whole:
            return trial.suggest_int(name, int(self.low), int(self.high), log=log)
        value = trial.suggest_float(name, self.low, self.high, log=log)
        return min(self.high, max(self.low, float(f"{value:.4g}")))

    def has(self, value: object) -> bool:
        """Return whether a value is one of these."""
        return isinstance(value, int | float) and self.low <= value <= self.high

    def __str__(self) -> str:
        return f"{self.low:g}..{self.high:g}"


@dataclass(frozen=True)
class Choice:
    """Some values."""

    values: tuple[Value, ...]

    def suggest(self, trial: Trial, name: str) -> Value:
        """Return a value that the sampler suggests."""
        return cast(Value, trial.suggest_categorical(name, self.values))

    def has(self, value: object) -> bool:
        """Return whether a value is one of these."""
        return value in self.values

    def __str__(self) -> str:
        return ",".join(map(text_of, self.values))


Values = Range | Choice
Given = (
    str | Sequence[Value] | None
)  # a range as text or as (low, high), or a list of values; None: the usual one


@dataclass(frozen=True)
class Dimension:
    """An option of the solver or a param of the model, and the values that it may have."""

    name: str
    values: Values
    is_param: bool = False

    def __str__(self) -> str:
        return f"{'param ' if self.is_param else ''}{self.name}={self.values}"


OPTIONS: Mapping[str, Values] = {
    "scenarios": Range(50, 2000, whole=True),
    "depth": Range(10, 180, whole=True),
    "xi": Range(0.3, 0.99),
    "rollouts": Range(1, 12, whole=True),
    "pruning": Choice(("auto", 0, 0.01, 0.1, 1)),
    "exploration": Range(0.0, 1.0),
    "observation_loss": Range(0.0, 2.0),
    "in_flight": Range(1, 512, whole=True),
    "particles": Range(500, 20000, whole=True),
    "belief": Choice(("factored", "particle")),
}
_OF_A_TREE = ("scenarios", "depth", "xi", "rollouts", "pruning", "exploration")
USUAL: Mapping[str, tuple[str, ...]] = {
    "default": (),
    "rollout": ("scenarios", "depth"),
    "despot": _OF_A_TREE,
    "parallel": (*_OF_A_TREE, "observation_loss"),
    "pomcp": ("scenarios", "depth", "rollouts", "exploration"),
    "gpu": (*_OF_A_TREE, "observation_loss", "in_flight"),
    "hyp": (*_OF_A_TREE, "observation_loss", "in_flight"),
}


def option(name: str, given: Given) -> Dimension:
    """Return an option with the values that a user gives, or the usual ones."""
    name = name.replace("-", "_")
    if name not in OPTIONS:
        nearest = did_you_mean(name, tuple(OPTIONS)) or f"there are {', '.join(OPTIONS)}"
        raise TuningError(f"no option {name!r} can be tuned: {nearest}")
    usual = OPTIONS[name]
    if given is None:
        return Dimension(name, usual)
    is_whole = isinstance(usual, Range) and usual.whole
    return Dimension(name, _values(name, given, is_whole))


def param(model: ir.Model, name: str, given: Given) -> Dimension:
    """Return a param with the values that a user gives, or all of its type."""
    found = next((one for one in model.params if one.name == name), None)
    if found is None:
        names = tuple(one.name for one in model.params)
        nearest = did_you_mean(name, names) or f"it has {', '.join(names) or 'none'}"
        raise TuningError(f"the model has no param {name!r}: {nearest}")
    if found.indices:
        raise TuningError(f"the param {name!r} is an array; one with a single value can be tuned")
    if name in _params_of_what_is_seen(model):
        raise TuningError(
            f"the param {name!r} changes what is visible or legal: the planner has to have the world's"
        )
    values = _of_type(found) if given is None else _values(name, given, isinstance(found.type, Int))
    if isinstance(found.type, Bool | Enum) and given is not None:
        all_of_type = _of_type(found)
        if wrong := [one for one in _listed(values, name) if not all_of_type.has(one)]:
            raise TuningError(f"{name}: {text_of(wrong[0])} is no value of it; there are {all_of_type}")
    if isinstance(found.type, Int | Float) and isinstance(values, Range):
        is_inside = found.type.low <= values.low and values.high <= found.type.high
        if not is_inside:
            raise TuningError(f"{name}={values}: the param's type is {found.type}")
    return Dimension(name, values, is_param=True)


def default_of(model: ir.Model, dimension: Dimension) -> Value | None:
    """Return the model's own value of a tuned param."""
    found = next(one for one in model.params if one.name == dimension.name)
    if found.default is None:
        return None
    [value] = found.default
    if isinstance(found.type, Float):
        return float(str(np.float32(value)))  # as the text has it, where the model has the nearest float32
    return found.type.variants[int(value)].name if isinstance(found.type, Enum) else value


def text_of(value: Value) -> str:
    """Return a value as people write it."""
    return (
        str(value).lower()
        if isinstance(value, bool)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )


def _listed(values: Values, name: str) -> tuple[Value, ...]:
    if isinstance(values, Range):
        raise TuningError(f"{name}={values}: it has no range; list values, separated by commas")
    return values.values


def _of_type(found: ir.Param) -> Values:
    match found.type:
        case Bool():
            return Choice((False, True))
        case Int(low=low, high=high) if str(found.type) != "int":
            return Range(low, high, whole=True)
        case Float(low=low, high=high) if math.isfinite(low) and math.isfinite(high):
            return Range(low, high)
        case Enum(variants=variants) if all(one.argument is None for one in variants):
            return Choice(tuple(one.name for one in variants))
    raise TuningError(
        f"the param {found.name!r} is a {found.type}, which has no range: give {found.name}=LOW..HIGH"
    )


def _values(name: str, given: str | Sequence[Value], is_whole: bool) -> Values:
    if not isinstance(given, str):
        pair = [one for one in given if isinstance(one, int | float) and not isinstance(one, bool)]
        if isinstance(given, tuple) and len(pair) == len(given) == 2:
            return _range(name, pair[0], pair[1], is_whole)
        return _choice(name, list(given))
    low, dots, high = given.partition("..")
    if not dots:
        return _choice(name, [value(text.strip()) for text in given.split(",") if text.strip()])
    ends = [value(low.strip()), value(high.strip())]
    if not all(isinstance(end, int | float) and not isinstance(end, bool) for end in ends):
        raise TuningError(f"{name}={given}: a range is LOW..HIGH, two numbers")
    return _range(name, float(ends[0]), float(ends[1]), is_whole)


def _range(name: str, low: float, high: float, is_whole: bool) -> Range:
    if not low < high or not math.isfinite(low) or not math.isfinite(high):
        raise TuningError(f"{name}={low:g}..{high:g}: the range is empty")
    if is_whole and (low != int(low) or high != int(high)):
        raise TuningError(f"{name}={low:g}..{high:g}: its values are whole numbers")
    return Range(low, high, is_whole)


def _choice(name: str, values: Sequence[Value]) -> Choice:
    if not values or len(set(map(text_of, values))) < len(values):
        raise TuningError(f"{name}: expected LOW..HIGH, or different values separated by commas")
    return Choice(tuple(values))


def value(text: str) -> Value:
    """Return a number, a truth value or a name."""
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            continue
    return {"true": True, "false": False}.get(text, text)


def _params_of_what_is_seen(model: ir.Model) -> set[str]:
    """Return the params that visible variables and legal actions depend on, hidden variables left out."""
    visible = {one.name for one in model.variables if one.visible}
    functions = {one.name: one for one in model.functions}
    lets = {one.name: one for one in model.lets}

    def nodes() -> Iterator[ir.Expr | ir.Dist]:
        yield model.legal
        yield from (one.dist for one in (*model.inits, *model.updates) if one.variable in visible)

    return {node.param for node, _ in reached(nodes(), functions, lets) if isinstance(node, ir.ParamRead)}
