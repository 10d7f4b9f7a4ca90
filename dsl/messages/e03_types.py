# SPDX-License-Identifier: Apache-2.0
"""Texts of E03xx about types that do not fit: E0301, E0304, E0308, E0310 and E0314.

Calls and indexes are in ``e03_calls``, patterns in ``e03_match``, units in ``e03_units``, arrays, records and
grids in ``e03_values``. ``what`` names the place that asks for a type: ``the value``, ``argument 'x'``.
"""

from __future__ import annotations

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import described
from hypgen.dsl.types import Bool, Enum, Float, Int, Record, Type


def mismatch(what: str, target: Type, found: Type, span: Span) -> Diagnostic:
    """A value of another type than the one asked for."""
    if isinstance(target, Bool) and isinstance(found, Int | Float):
        remedy = "compare it, as in x > 0"
        remedy += "; a draw with this probability is bernoulli(..)" if isinstance(found, Float) else ""
    elif isinstance(found, Bool) and isinstance(target, Int | Float):
        remedy = "write: if .. then 1 else 0"
    else:
        remedy = f"give a value of type {target}"
    message = f"{what} must be of type {target}, but this is {described(found)}"
    return Diagnostic("E0301", message, span, remedy)


def probability_for_draw(what: str, span: Span) -> Diagnostic:
    """A draw of a truth value that is written as its probability."""
    message = f"{what} must be of type bool, but this is a float"
    return Diagnostic("E0301", message, span, "write bernoulli(..), which is true with this probability")


def float_for_int(what: str, span: Span, is_index: bool = False) -> Diagnostic:
    """A float where an int is asked for; one for an index may be a largest value in place of where it is."""
    message = f"{what} must be an int, but this is a float"
    remedy = "round it: floor(..), ceil(..) or round(..)"
    if is_index:
        remedy += "; where a value is largest, argmax(i in T: ..) says"
    return Diagnostic("E0301", message, span, remedy)


def float_as_index(span: Span) -> Diagnostic:
    """A float as an index of ``at``."""
    remedy = "round it first: floor(..), ceil(..) or round(..)"
    return Diagnostic("E0301", "an index must be an int, but this is a float", span, remedy)


def float_into_int_range(function: str, span: Span) -> Diagnostic:
    """A float that ``function`` (``clamp``) is to force into a range of ints."""
    remedy = f"round it first: {function}(floor(..)), {function}(ceil(..)) or {function}(round(..))"
    return Diagnostic("E0301", "an int is needed, but this is a float", span, remedy)


def branches_differ(first: Type, found: Type, span: Span, first_span: Span) -> Diagnostic:
    """A branch of another type than the first one."""
    return Diagnostic(
        "E0301",
        f"the branches differ: one is {described(first)}, this is {described(found)}",
        span,
        "give all branches the same type",
        ((first_span, f"this is {described(first)}"),),
    )


def draw_of_numbers(what: str, target: Type, found: Int | Float, span: Span) -> Diagnostic:
    """A draw of numbers where another type is asked for."""
    number = "an int" if isinstance(found, Int) else "a float"
    if isinstance(target, Float):
        remedy = "name the draw with 'let name ~ ..' and use the name: an int widens to a float"
    elif isinstance(target, Bool):
        remedy = "name the draw with 'let name ~ ..' and compare the name, as in name > 0"
    else:
        remedy = "draw with a table, {value: probability, else other}"
    return Diagnostic("E0301", f"{what} must be of type {target}, but this draws {number}", span, remedy)


def draw_of_bins(what: str, target: Type, span: Span) -> Diagnostic:
    """``binned`` where something else than an int is asked for."""
    message = f"{what} must be of type {target}, but binned(..) draws an int"
    return Diagnostic("E0301", message, span, "declare a range with one value for each bin, such as 0 .. 9")


def belief_of_other(function: str, found: Type, span: Span) -> Diagnostic:
    """``belief`` or ``deviation`` of a value without a mean."""
    what = "mean" if function == "belief" else function
    message = f"{function}(..) is a {what}, of a bool or a number, but this is {found}"
    return Diagnostic("E0301", message, span, f"ask for a condition: {function}(x == value)")


def value_as_condition(connective: str, written: str, again: str, span: Span) -> Diagnostic:
    """``x == a or b``; ``written`` is b, and ``again`` the comparison that is meant: ``x == b``."""
    message = f"'{connective}' joins conditions, and '{written}' is a value"
    return Diagnostic("E0301", message, span, f"write the comparison again: {connective} {again}")


def compares_types(op: str, left: Type, right: Type, span: Span) -> Diagnostic:
    """A comparison of values of two types."""
    message = f"'{op}' is given two types: {described(left)}, {described(right)}"
    return Diagnostic("E0301", message, span, "compare values of the same type")


def reward_not_a_number(found: Type, span: Span) -> Diagnostic:
    """A reward of another type."""
    message = f"a reward must be a number, but this is {described(found)}"
    return Diagnostic("E0301", message, span, "write: if .. then .. else 0")


def array_of_arrays(span: Span) -> Diagnostic:
    """An array's type whose entries are arrays."""
    remedy = "list all indexes in one pair of brackets: T[A, B]"
    return Diagnostic("E0304", "an array of arrays", span, remedy)


def array_not_allowed(span: Span) -> Diagnostic:
    """An array's type where a value's is needed."""
    remedy = "give one value; what has an index is a const, a param, a variable or a function of it"
    return Diagnostic("E0304", "an array cannot stand here", span, remedy)


def not_finite(what: str, found: Type, instead: str, span: Span) -> Diagnostic:
    """A type of too many values; ``instead`` is what else could stand there, if anything special."""
    remedy = f"use {instead}" if instead else "use bool, a range a .. b, an enum or a record"
    return Diagnostic("E0304", f"{what} must have a finite type, not {found}", span, remedy)


def not_a_number(what: str, found: Type, span: Span) -> Diagnostic:
    """An operand that must be a number."""
    remedy = "write: if .. then 1 else 0" if isinstance(found, Bool) else "use ints or floats"
    if isinstance(found, Record):
        remedy = f"work on its fields: {', '.join(f'.{name}' for name, _ in found.fields)}"
    return Diagnostic("E0308", f"{what} must be a number, but this is {described(found)}", span, remedy)


def argument_not_a_number(function: str, found: Type, span: Span) -> Diagnostic:
    """An argument of a function of numbers."""
    message = f"'{function}' takes numbers, but this is {described(found)}"
    return Diagnostic("E0308", message, span, "use ints or floats")


def parameter_not_a_number(parameter: str, found: Type, span: Span) -> Diagnostic:
    """A parameter of a draw of numbers: ``the mean``, ``the lower end``."""
    remedy = "use a number"
    if parameter.endswith("end") and isinstance(found, Bool | Enum):
        remedy += f"; all values of a type alike are uniform({found})"
    return Diagnostic("E0308", f"{parameter} is a number, but this is {described(found)}", span, remedy)


def summand_not_a_number(found: Type, span: Span) -> Diagnostic:
    """What ``sum`` adds."""
    remedy = "count with count(i in T where ..)" if isinstance(found, Bool) else "use ints or floats"
    return Diagnostic("E0308", f"'sum' adds numbers, but this is {described(found)}", span, remedy)


def extreme_of_other(quantifier: str, found: Type, span: Span) -> Diagnostic:
    """What ``min``, ``argmax`` and the like compare."""
    message = f"'{quantifier}' compares numbers, but this is {described(found)}"
    return Diagnostic("E0308", message, span, "use ints or floats")


def index_of_other(found: Type, span: Span) -> Diagnostic:
    """``index`` of what is neither an enum's nor a record's value."""
    message = f"'index' gives an enum's place, but this is {described(found)}"
    return Diagnostic("E0308", message, span, "use it for values of enums and records")


def match_of_other(found: Type, span: Span) -> Diagnostic:
    """``match`` of a value whose type has no patterns."""
    message = f"'match' takes an enum, a bool or an int, but this is {described(found)}"
    return Diagnostic("E0308", message, span, "use if .. then .. else")


def is_of_other(found: Type, span: Span) -> Diagnostic:
    """``is`` of a value that is no enum's."""
    message = f"'is' asks for the variant of an enum's value, but this is {described(found)}"
    return Diagnostic("E0308", message, span, "compare other values with ==")


def with_of_other(found: Type, span: Span) -> Diagnostic:
    """``with`` behind a value that is no record."""
    message = f"'with' changes fields of a record, but this is {described(found)}"
    return Diagnostic("E0308", message, span, "write it behind a record: p with { x = 1 }")


def without_order(found: Type, span: Span) -> Diagnostic:
    """``<`` and the like between values that are no numbers."""
    remedy = "use == or !=, or index(..) for a variant's place in its enum"
    return Diagnostic("E0308", f"values of type {found} have no order", span, remedy)


def integer_division_of_float(op: str, span: Span) -> Diagnostic:
    """``//`` or ``%`` of a float."""
    return Diagnostic("E0308", f"'{op}' is of ints, but this is a float", span, "use floor(a / b)")


def no_ends(function: str, span: Span) -> Diagnostic:
    """``clamp`` and the like without ends where no range is asked for."""
    message = f"{function}(..) takes its ends from the range that is asked for, and here none is"
    remedy = f"give the ends, {function}(x, low, high), or a type: let v: T = {function}(x)"
    return Diagnostic("E0310", message, span, remedy)


def no_ends_of_draw(span: Span) -> Diagnostic:
    """``clamp`` of a draw without ends where no range is asked for."""
    message = "clamp(..) takes its ends from the range that is asked for, and here none is"
    remedy = "give the ends, clamp(.., low, high), or a type: let v: T ~ clamp(..)"
    return Diagnostic("E0310", message, span, remedy)


def observation_compares_floats(name: str, span: Span) -> Diagnostic:
    """An observation whose law depends on whether two floats are equal."""
    message = f"'{name}' tests floats for equality, which rounding decides"
    return Diagnostic("E0314", message, span, "compare with a tolerance, abs(a - b) < 0.001, or with < and >")
