# SPDX-License-Identifier: Apache-2.0
"""Texts of E06xx: values outside their range, and types, tables and computations that are too large.

``what`` names the place of a value: ``the value``, ``argument 'x'``. In a branch that a constant condition
rules out, these mistakes are none, and all others are (``report.unreachable``).
"""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import lies
from hypgen.dsl.types import Int, Type

TOO_MANY_STEPS = "E0609"
WITHOUT_VALUE = ("E0603", "E0612")  # of a division by zero, and of a function that has no value


def outside_range(what: str, found: Int, target: Int, is_constant: bool, span: Span) -> Diagnostic:
    """An int that may lie outside the range asked for."""
    low, high = target.low, target.high
    remedy = (
        f"write clamp(..), wrap(..), checked(..) or clamp(.., {low}, {high}), or guard it with a condition"
    )
    if is_constant:
        remedy = f"use a value from {low} to {high}"
    message = f"{what} {lies(found.low, found.high)}, which does not fit {low} .. {high}"
    return Diagnostic("E0601", message, span, remedy)


def index_outside_range(what: str, found: Int, target: Int, is_constant: bool, span: Span) -> Diagnostic:
    """An index that may lie outside the array."""
    low, high = target.low, target.high
    remedy = f"clamp it, clamp(.., {low}, {high}), guard it with a condition, or read at(array, .., default)"
    if is_constant:
        remedy = f"use a value from {low} to {high}"
    message = f"{what} {lies(found.low, found.high)}, which does not fit {low} .. {high}"
    return Diagnostic("E0602", message, span, remedy)


def draw_outside_range(what: str, found: Int, target: Int, span: Span) -> Diagnostic:
    """A draw that may give ints outside the range asked for."""
    message = f"{what} {lies(found.low, found.high)}, which does not fit {target.low} .. {target.high}"
    return Diagnostic("E0601", message, span, "write clamp(..) around the draw, or give it other ends")


def distance_outside_range(start: str, end: str, distance: float, element: Type, span: Span) -> Diagnostic:
    """A distance that the table's type does not hold."""
    message = f"the distance from {start} to {end} is {distance:g}, which does not fit {element}"
    return Diagnostic("E0601", message, span, "give the table a wider type, such as float or int")


def never_in_range(least: float, most: float, low: float, high: float, span: Span) -> Diagnostic:
    """``checked`` of a value that lies outside its ends for certain."""
    message = f"this {lies(least, most)}, which never fits {low} .. {high}"
    return Diagnostic("E0601", message, span, "correct the value or the range")


def division_by_zero(span: Span) -> Diagnostic:
    """A divisor that is 0."""
    return Diagnostic("E0603", "this divides by zero", span, "divide by something else than 0")


_DEFINED = {
    "sqrt": "it takes numbers from 0 up",
    "log": "it takes numbers above 0",
    "log2": "it takes numbers above 0",
    "asin": "it takes numbers from -1 to 1",
    "acos": "it takes numbers from -1 to 1",
    "exp": "it takes numbers up to 88",
    **dict.fromkeys("+-*/", "use a larger unit: floats end at 3.4e38"),
}


def without_value(function: str, operands: Sequence[float], span: Span) -> Diagnostic:
    """A function of constants that is infinite or no number; ``function`` as it is written."""
    of = " and ".join(f"{operand:g}" for operand in operands)
    message = f"'{function}' of {of} has no finite value"
    return Diagnostic("E0612", message, span, _DEFINED.get(function, "give it operands of which it has one"))


def beyond_float32(value: float, span: Span) -> Diagnostic:
    """A literal that no float holds."""
    return Diagnostic("E0604", f"{value:g} is beyond 32-bit floats", span, "use a larger unit")


def beyond_int32(found: Int, span: Span) -> Diagnostic:
    """An int that may leave 32 bits."""
    remedy = "give the operands smaller types, clamp them, or compute with floats"
    return Diagnostic("E0604", f"this {lies(found.low, found.high)}, beyond 32-bit integers", span, remedy)


def large_exponent(exponent: float, span: Span) -> Diagnostic:
    """A power of ints whose exponent is too large to bound the result."""
    message = f"the exponent {exponent} is too large for ints"
    return Diagnostic("E0604", message, span, "raise a float instead, as in 2.0 ** k")


def empty_range(low: int, high: int, span: Span) -> Diagnostic:
    """A range type whose ends are swapped."""
    remedy = "write the smaller end first; both ends belong to the range"
    return Diagnostic("E0605", f"the range {low} .. {high} has no values", span, remedy)


def empty_enum(name: str, span: Span) -> Diagnostic:
    """An enum without variants."""
    return Diagnostic("E0605", f"enum '{name}' has no variants", span, "name at least one")


def empty_record(name: str, span: Span) -> Diagnostic:
    """A record without fields."""
    return Diagnostic("E0605", f"record '{name}' has no fields", span, "give it at least one")


def empty_wrap(span: Span) -> Diagnostic:
    """``wrap`` of a float into a range of length 0."""
    return Diagnostic("E0605", "the range to wrap into is empty", span, "the ends must differ")


def swapped_ends(function: str, span: Span) -> Diagnostic:
    """A call of ``clamp``, ``uniform`` or the like whose lower end lies above the upper."""
    message = f"the lower end of {function} lies above the upper"
    return Diagnostic("E0605", message, span, "swap the ends")


def ends_not_apart(function: str, span: Span) -> Diagnostic:
    """A call of ``truncated`` or ``binned`` whose ends leave no room between them."""
    message = f"the lower end of {function} does not lie below the upper"
    return Diagnostic("E0605", message, span, "swap the ends")


def many_counts(last: int, most: int, span: Span) -> Diagnostic:
    """A limited draw of counts that goes on further than laws are tabulated."""
    message = f"counts up to {last} are too many"
    return Diagnostic("E0605", message, span, f"use an end of at most {most}")


def many_actions(span: Span) -> Diagnostic:
    """An action with more joint values than 31 bits count."""
    return Diagnostic("E0605", "there are too many joint actions", span, "use smaller types")


def many_values(name: str, count: int, span: Span) -> Diagnostic:
    """A declared type with more values than 31 bits count."""
    message = f"'{name}' has {count} values, more than fit 31 bits"
    return Diagnostic("E0605", message, span, "use smaller types")


def many_entries(count: int, most: int, span: Span) -> Diagnostic:
    """An array's type with too many entries."""
    message = f"the array has {count} entries, more than {most}"
    return Diagnostic("E0605", message, span, "use smaller index types")


def many_entries_of_comprehension(name: str, count: int, most: int, span: Span) -> Diagnostic:
    """A constant array with more entries than are computed one by one."""
    message = f"'{name}' has {count} entries, more than the {most} that a comprehension may give"
    return Diagnostic("E0605", message, span, "use smaller index types")


def long_memory(span: Span) -> Diagnostic:
    """Memory with more entries than 31 bits count."""
    return Diagnostic("E0605", "the array is too long", span, "use smaller index types")


def many_values_to_unfold(span: Span) -> Diagnostic:
    """A quantifier in a constant that goes through too many values."""
    message = "this runs over too many values for a constant"
    return Diagnostic("E0605", message, span, "use a smaller type")


def no_probability(what: str, least: float, most: float, span: Span) -> Diagnostic:
    """A number outside 0 .. 1 where a probability is asked for."""
    message = f"{what} {lies(least, most)}, which is no probability"
    remedy = "a probability lies in 0 .. 1"
    if 10 <= least == most <= 100:  # noqa: PLR2004
        remedy += f": {most:g} % is {most / 100:g}"
    return Diagnostic("E0606", message, span, remedy)


_KEPT_DEFINED = {
    "sqrt": "sqrt(max(.., 0))",
    "log": "log(max(.., 0.001))",
    "log2": "log2(max(.., 0.001))",
    "asin": "asin(clamp(.., -1, 1))",
    "acos": "acos(clamp(.., -1, 1))",
    "/": ".. / max(.., 0.001)",
    "**": "max(.., 0.001) ** ..",
}


def unlimited_reward(bounds: Sequence[str], reward: str, undefined: str | None, span: Span) -> Diagnostic:
    """A reward that keeps bounds from being derived; ``undefined``: what in it may have no value."""
    which = " and ".join(f"bound {name}" for name in bounds)
    message = f"{which} cannot be derived: nothing limits the reward '{reward}'"
    forms = "   ".join(f"bound {name} = .." for name in bounds)
    remedy = f"limit the reward with clamp(.., low, high), or declare {forms}"
    if undefined is not None:
        message += f", as '{undefined}' in it may have no value"
        remedy = f"keep what it is of in range, as in {_KEPT_DEFINED[undefined]}; clamp lets NaN through"
    return Diagnostic("E0607", message, span, remedy)


def large_return(step: float, whole: float, span: Span) -> Diagnostic:
    """Rewards that add up to more than a float holds."""
    most = f"a step earns or costs up to {step:.3g}, an episode up to {whole:.3g}"
    remedy = "use a larger unit, or limit the rewards with clamp(.., low, high)"
    return Diagnostic("E0611", f"{most}, which is beyond 32-bit floats", span, remedy)


def nothing_left(low: int, high: int, span: Span) -> Diagnostic:
    """A truncated draw of which no value lies between the ends."""
    message = f"nothing of this draw lies in {low} .. {high}"
    return Diagnostic("E0608", message, span, "move the ends to where values can lie")


def empty_set(span: Span) -> Diagnostic:
    """A draw from a set whose condition never holds."""
    return Diagnostic("E0608", "this draws from an empty set", span, "add 'else value'")


def only_zero_weights(span: Span) -> Diagnostic:
    """A draw by weights that are all 0."""
    return Diagnostic("E0608", "all weights are 0: there is nothing to draw", span, "add 'else value'")


def extreme_of_nothing(quantifier: str, span: Span) -> Diagnostic:
    """``min``, ``argmax`` and the like whose condition never holds."""
    message = f"'{quantifier}' of nothing: the condition never holds"
    return Diagnostic("E0608", message, span, "add 'else value'")


def many_steps_of_constant(what: str, span: Span) -> Diagnostic:
    """A constant array that takes too long to compute."""
    remedy = "use smaller types, or fewer values inside each other; a param can be read from a file"
    return Diagnostic(TOO_MANY_STEPS, f"{what} takes too many steps to compute", span, remedy)


def many_steps(span: Span) -> Diagnostic:
    """An expression that takes too long to compute."""
    remedy = "compute less of it, with smaller types or fewer calls"
    return Diagnostic(TOO_MANY_STEPS, "this takes too many steps to compute", span, remedy)


def many_nodes(count: int, most: int, span: Span) -> Diagnostic:
    """``distance`` over a type with too many values."""
    message = f"the distances between {count} values take too long to compute"
    remedy = f"use a type of {most} values or fewer, or give the table in a file of params"
    return Diagnostic(TOO_MANY_STEPS, message, span, remedy)


def many_links(count: int, span: Span) -> Diagnostic:
    """``distance`` along too many links."""
    message = f"the distances along {count} links take too long to compute"
    remedy = "link each value to its neighbours only, or give the table in a file of params"
    return Diagnostic(TOO_MANY_STEPS, message, span, remedy)


def negative_cost(start: str, end: str, cost: float, span: Span) -> Diagnostic:
    """A link of ``distance`` with a cost below 0."""
    message = f"the cost from {start} to {end} is {cost:g}"
    return Diagnostic("E0610", message, span, "shortest paths need costs of 0 or more")


def no_way(start: str, end: str, span: Span) -> Diagnostic:
    """Two values that no path of links connects."""
    message = f"no way leads from {start} to {end}"
    return Diagnostic("E0610", message, span, "say how far that is: add 'else value'")
