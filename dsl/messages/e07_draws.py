# SPDX-License-Identifier: Apache-2.0
"""Texts of E07xx: draws where none can stand, and draws that are not written as they should be."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Int, Record, Type

TABLE = "a table of weights"
_NAME_IT = "name the draw with 'let name ~ ..' and use the name"
_LET = "name the draw with 'let name ~ ...' in an element and read the name"
_WITHOUT_DRAWS = frozenset({"legal", "bound", "invariant", "draw", "first memory", "next memory"})
_SHIFT = "shift it in its mean, normal(mean + shift, sd); or "
_SCALE = "scale it inside, normal(factor * mean, factor * sd); or "
_NORMAL = {"+": _SHIFT, "-": _SHIFT, "*": _SCALE, "/": _SCALE}


def draw_behind_equals(span: Span) -> Diagnostic:
    """A draw behind ``=``."""
    return Diagnostic("E0701", "this is a draw, and '=' is exact", span, "write '~' in place of '=' to draw")


def misplaced_draw(what: str, owner: str, span: Span) -> Diagnostic:
    """A draw where a value is needed; ``owner`` is the kind of declaration that it stands in."""
    remedy = _LET
    if owner == "function":
        remedy = "make it a distribution, fn name(..): type ~ .., and draw from it"
    elif owner == "constant":
        remedy = "give a number; a variable may be drawn at the start: hidden fixed name: T  init name ~ .."
    elif owner in _WITHOUT_DRAWS:
        remedy = "let a variable hold what is drawn, name' ~ .., and read that"
    if what == TABLE:
        remedy += "; to choose by a value, match value { first => a  else => b }"
    return Diagnostic("E0702", f"{what} is a draw, and a value is needed here", span, remedy)


def draw_for_each(span: Span) -> Diagnostic:
    """A draw in what a quantifier or a set evaluates for each value of a type."""
    remedy = "let an array hold what is drawn, name' ~ [i in T: ..], and read name[i]; "
    remedy += "how many of n happen is binomial(n, p)"
    return Diagnostic("E0702", "this draws anew for each value, and a value is needed here", span, remedy)


def draw_of_drawn(name: str, span: Span) -> Diagnostic:
    """A draw as the value of ``uniform(name in T: value)``."""
    message = "the value of uniform(..) is a draw, and one draw has one number"
    return Diagnostic("E0702", message, span, f"draw one after the other: let {name} ~ uniform(T) in ..")


def continuous_part(owner: str, op: str, span: Span) -> Diagnostic:
    """A draw of a float within a draw; ``op`` is the operator that a normal one is given to, if it is."""
    message = "this draws from a continuum, so that what is made of it has no density"
    remedy = _LET
    if owner in ("init", "observe"):
        remedy = "draw the bin that it falls into: let name: 0 .. 9 ~ binned(.., low, high) in .."
    elif owner.startswith("policy"):
        remedy = "name the draw with 'let name ~ ...' in the policy and read the name"
    return Diagnostic("E0710", message, span, _NORMAL.get(op, "") + remedy)


def large_part(owner: str, values: int, most: int, span: Span) -> Diagnostic:
    """A draw within a draw of too many values to sum over; ``owner`` is the declaration's kind."""
    message = f"this draws one of {values} values, and a draw within a draw has at most {most}"
    remedy = "limit it: clamp(.., low, high)"
    if owner == "init":
        remedy += "; or let another variable draw it, init other ~ .., and read that"
    elif owner != "observe":
        place = "the policy" if owner.startswith("policy") else "an element"
        remedy += f"; or name it with a 'let' in {place}"
    return Diagnostic("E0710", message, span, remedy)


def many_draws(most: int, span: Span) -> Diagnostic:
    """A draw with too many others inside it."""
    message = f"more than {most} draws stand within each other"
    return Diagnostic("E0710", message, span, "name some of them in an element: let name ~ ..")


def no_weights(span: Span) -> Diagnostic:
    """A table without entries."""
    return Diagnostic("E0703", "the table has no weights", span, "write {value: probability, else other}")


def swapped_entries(span: Span) -> Diagnostic:
    """A table with probabilities where the values stand."""
    message = "a value stands before its probability, and here a probability comes first"
    return Diagnostic("E0703", message, span, "write { value: probability, .. }")


def wrong_sum(total: float, span: Span) -> Diagnostic:
    """A table of constant weights that do not sum to 1."""
    remedy = "make them sum to 1, or give the remainder to 'else value'"
    return Diagnostic("E0703", f"the weights sum to {total:g}", span, remedy)


def wrong_sum_with_else(total: float, span: Span) -> Diagnostic:
    """A table with ``else`` whose other weights sum to more than 1."""
    remedy = "weights and 'else' together are 1: make the weights smaller"
    return Diagnostic("E0703", f"the weights sum to {total:g}", span, remedy)


def primed_draw(span: Span) -> Diagnostic:
    """A prime behind a draw."""
    remedy = "prime the values that the draw reads instead"
    return Diagnostic("E0704", "a draw cannot be primed", span, remedy)


def primed_read_of_draw(route: str, span: Span) -> Diagnostic:
    """A prime under which a draw is read; ``route`` is the path of reads, in words."""
    remedy = "remove the prime, or prime the variables alone"
    return Diagnostic("E0704", f"a draw cannot be primed: {route}", span, remedy)


def noisy_without_type(span: Span) -> Diagnostic:
    """``noisy`` of an int in a let without a type."""
    message = "which other values this noisy draw can give is not known"
    return Diagnostic("E0705", message, span, "give the let a type: let name: T ~ noisy(..)")


def binned_without_type(span: Span) -> Diagnostic:
    """``binned`` where no range is asked for."""
    remedy = "give a type with one value for each bin: let name: 0 .. 9 ~ binned(..)"
    return Diagnostic("E0705", "how many bins there are is not known", span, remedy)


def uniform_of_other(span: Span) -> Diagnostic:
    """``uniform`` of what is no type."""
    remedy = "name a finite type, uniform(T), or write uniform(low, high); a few values are a table"
    return Diagnostic("E0705", "uniform(..) takes a type, or two ends", span, remedy)


def uniform_without_value(span: Span) -> Diagnostic:
    """``uniform`` over several names that does not say what to draw."""
    return Diagnostic("E0705", "what to draw is not said", span, "add ': value' after the binders")


def weighted_without_form(span: Span) -> Diagnostic:
    """``weighted`` over several names, or without a weight."""
    message = "weighted(..) draws a value of one type, by its weight"
    remedy = "write weighted(i in T: weight); for several names use a record type"
    return Diagnostic("E0705", message, span, remedy)


def array_for_draw(target: Type | None, span: Span) -> Diagnostic:
    """A list where one value, of the type ``target`` if that is known, is asked for."""
    message = "an array stands where one value is asked for"
    if isinstance(target, Record):
        fields = ", ".join(name for name, _ in target.fields)
        message = f"an array stands where a value of '{target}' is asked for"
        return Diagnostic("E0706", message, span, f"write {target}({fields})")
    remedy = "give one entry; what has an index is a variable, or a function of it: fn name(i: T): bool = .."
    return Diagnostic("E0706", message, span, remedy)


def list_of_probabilities(values: Sequence[str], span: Span) -> Diagnostic:
    """A list of numbers where a table of probabilities is meant; ``values`` are those of the type."""
    entries = ", ".join(f"{value}: .." for value in values)
    message = "a draw by probabilities is a table, not a list"
    return Diagnostic("E0706", message, span, f"write {{ {entries} }}")


def row_of_matrix(label: str, target: Type, span: Span) -> Diagnostic:
    """A matrix with an index less than it has, where a value of its last index is drawn."""
    remedy = f"draw by the row's entries: weighted(v in {target}: {label}[.., v])"
    return Diagnostic("E0706", f"this is a row of '{label}', and one value is asked for", span, remedy)


def draw_for_array(name: str, indices: Sequence[Type], span: Span) -> Diagnostic:
    """One value or draw where an array's entries must be said."""
    wanted = ", ".join(f"{b} in {t}" for b, t in zip("ijklmnpqrstuvw", indices, strict=False))
    message = f"'{name}' is an array: say what each entry is"
    return Diagnostic("E0706", message, span, f"write [{wanted}: ..], or a list of its entries")


def draw_in_list(name: str, span: Span) -> Diagnostic:
    """A draw as an entry of a list."""
    message = f"this entry of '{name}' is a draw, and a list has values"
    remedy = "write [i in T: ..], where each entry is drawn on its own; a const can say how entries differ"
    return Diagnostic("E0706", message, span, remedy)


def draw_for_record(record: str, form: str, span: Span) -> Diagnostic:
    """A draw of a record as a whole; ``form`` is how its value is written."""
    message = f"this draws '{record}' as a whole, and each of its fields is a draw"
    remedy = f"write {form} of draws, or draw which one it is under a name of its own, and use that"
    return Diagnostic("E0706", message, span, remedy)


def not_above_zero(parameter: str, most: float, span: Span) -> Diagnostic:
    """A standard deviation, rate or the like that is 0 or less for certain."""
    message = f"{parameter} must be above 0, but it is {most:g}"
    return Diagnostic("E0707", message, span, "make it positive")


def poisson_mean(mean: float, most: float, span: Span) -> Diagnostic:
    """A mean of ``poisson`` that lies outside 0 .. ``most`` for certain."""
    message = f"the mean of poisson is {mean:g}, outside 0 .. {most:g}"
    return Diagnostic(
        "E0707", message, span, "use a mean in this range; for larger ones, normal(..) comes close"
    )


def binomial_trials(trials: Int, most: int, span: Span) -> Diagnostic:
    """A number of trials of ``binomial`` that may lie outside 0 .. ``most``."""
    message = f"the number of trials ranges over {trials.low} .. {trials.high}, outside 0 .. {most}"
    return Diagnostic("E0707", message, span, f"clamp it: clamp(.., 0, {most}), or give it a smaller type")


def negative_weights(span: Span) -> Diagnostic:
    """Weights that are below 0 for certain."""
    return Diagnostic("E0707", "the weights lie below 0", span, "give weights from 0 up")


def continuum_for_int(what: str, target: Type, span: Span) -> Diagnostic:
    """A continuous draw where an int is asked for."""
    return Diagnostic(
        "E0708",
        f"{what} must be of type {target}, but this draws from a continuum",
        span,
        "draw the bin that it falls into, binned(.., low, high), or name the draw and round it: "
        "let name ~ ..",
    )


def unlimited_poisson(span: Span) -> Diagnostic:
    """A draw of counts without end where a finite type is asked for."""
    return Diagnostic(
        "E0708",
        "a poisson draw has no largest value",
        span,
        "limit it: clamp(poisson(..)) to the range asked for, clamp(poisson(..), low, high), or "
        "truncated(poisson(..), low, high)",
    )


def not_truncated(span: Span) -> Diagnostic:
    """``truncated`` of a law that has no truncated form."""
    return Diagnostic(
        "E0709",
        "'truncated' takes a draw by normal, exponential, uniform, poisson or binomial",
        span,
        "draw from the values that are left: a table, uniform(i in T where ..) or weighted(i in T where ..)",
    )


def floats_not_clamped(span: Span) -> Diagnostic:
    """``clamp`` of a draw of floats by another law."""
    message = "'clamp' takes a draw by normal, exponential, uniform or truncated(..) of them"
    return Diagnostic("E0709", message, span, _NAME_IT)


def ints_not_clamped(span: Span) -> Diagnostic:
    """``clamp`` of a draw of ints by another law."""
    message = "'clamp' takes a draw by normal, exponential, uniform, poisson, binomial or a table"
    return Diagnostic("E0709", message, span, "name the draw and clamp the name: let x ~ .. in clamp(x)")


def not_cumulative(span: Span) -> Diagnostic:
    """``cdf`` of a law without a formula for it."""
    message = "'cdf' takes a draw by normal, exponential or uniform of floats"
    return Diagnostic(
        "E0709",
        message,
        span,
        "write it as a function: fn below(x: int): prob = sum(k in 0 .. 9 where k < x: ..)",
    )


def value_not_binned(span: Span) -> Diagnostic:
    """``binned`` of what is no draw."""
    message = "'binned' takes a draw, and this is a value"
    return Diagnostic("E0709", message, span, "give it noise, normal(value, deviation); or use floor(..)")


def not_binned(span: Span) -> Diagnostic:
    """``binned`` of a draw by another law."""
    message = "'binned' takes a draw by normal, uniform, exponential or truncated(..) of them"
    return Diagnostic("E0709", message, span, _NAME_IT)
