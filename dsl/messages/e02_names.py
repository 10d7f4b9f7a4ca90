# SPDX-License-Identifier: Apache-2.0
"""Texts of E02xx: names that are unknown, taken, ambiguous or used as what they are not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import described
from hypgen.dsl.types import Enum, Record, Type
from hypgen.dsl.types.builtin_names import FOREIGN_FUNCTIONS, FOREIGN_TYPES


def unknown_name(name: str, remedy: str, span: Span) -> Diagnostic:
    """A value's name that nothing declares."""
    return Diagnostic("E0201", f"there is nothing called '{name}' here", span, remedy)


def wildcard(span: Span) -> Diagnostic:
    """A ``_`` that is no local; in a pattern it would be one."""
    remedy = "ask by a pattern: match value { variant(_) => true  else => false }"
    return Diagnostic("E0201", "'_' stands for any value in patterns alone", span, remedy)


_SIGN_MEANS = {"//": "divides", "%": "is a remainder", "--": "subtracts a negative value"}


def behind_comment_sign(found: Diagnostic, sign: str, span: Span) -> Diagnostic:
    """A mistake behind ``//``, ``%`` or ``--``, which start comments elsewhere: a name may be prose."""
    if found.code not in ("E0201", "E0204") or found.span != span:
        return found
    comment = f"a comment starts with #; {sign} {_SIGN_MEANS[sign]}, and then this has to be declared"
    close = found.remedy.startswith("did you mean")
    return replace(found, remedy=f"{found.remedy} Or {comment}" if close else comment)


def unknown_in_variant(found: Diagnostic, variant: str, span: Span) -> Diagnostic:
    """A mistake in what a variant carries, which may be a name that its author meant to introduce."""
    if found.code != "E0201" or found.span != span:
        return found
    if found.message.startswith("'_'"):
        return replace(found, remedy=f"ask for the variant of any value: value is {variant}")
    way = f"match value {{ {variant}(name) => ..  else => .. }} names what is carried"
    return replace(found, remedy=f"{found.remedy}; {way}")


def unknown_member_index(found: Diagnostic, family: str, index: Type, span: Span) -> Diagnostic:
    """A mistake in a family's index, which may be a name that nothing runs over."""
    if found.code != "E0201" or found.span != span or not found.remedy.startswith("declare it"):
        return found
    name = found.message.split("'")[1]
    remedy = f"name a member, {family}[..], or run over all: sum({name} in {index}: ..)"
    return replace(found, remedy=remedy)


def duplicate(name: str, span: Span, first: Span) -> Diagnostic:
    """A name that is declared a second time."""
    return Diagnostic(
        "E0202",
        f"'{name}' is already declared",
        span,
        "rename or remove one of the two",
        ((first, f"'{name}' is first declared here"),),
    )


def duplicate_field(record: str, field: str, span: Span) -> Diagnostic:
    """A field that a record declares a second time."""
    message = f"record '{record}' has two fields '{field}'"
    return Diagnostic("E0202", message, span, "rename or remove one of the two")


def built_in(name: str, span: Span) -> Diagnostic:
    """A declaration of a name that the language has."""
    return Diagnostic("E0202", f"'{name}' is built in", span, "choose another name")


def default_as_member(span: Span) -> Diagnostic:
    """A let or memory of the policy that is called as the policy itself."""
    return Diagnostic("E0202", "'default' is the policy itself", span, "choose another name")


def shadows(name: str, what: str, span: Span, declared: Span) -> Diagnostic:
    """A local that would hide a declaration; ``what`` is that in words: ``a const``."""
    return Diagnostic(
        "E0202",
        f"'{name}' shadows {what} of that name",
        span,
        "choose another name",
        ((declared, f"'{name}' is declared here"),),
    )


def shadows_local(name: str, span: Span) -> Diagnostic:
    """A local that would hide a local around it."""
    return Diagnostic("E0202", f"'{name}' shadows an outer local of that name", span, "choose another name")


def shadows_record(name: str, span: Span) -> Diagnostic:
    """A local that would hide a record."""
    return Diagnostic("E0202", f"'{name}' shadows a record of that name", span, "choose another name")


def unknown_type(name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A type's name that nothing declares."""
    own = FOREIGN_TYPES.get(name.lower())
    remedy = f"write {own}" if own else did_you_mean(name, known) or f"declare it: type {name} = 0 .. 9"
    return Diagnostic("E0203", f"there is no type '{name}'", span, remedy)


def unknown_function(name: str, own: str | None, known: Iterable[str], span: Span) -> Diagnostic:
    """A call of what nothing declares; ``own`` is how this language writes a function of others."""
    remedy = f"write {own}" if own else did_you_mean(name, known)
    return Diagnostic(
        "E0204", f"there is no function '{name}'", span, remedy or f"declare it: fn {name}(..): type = .."
    )


def not_a_function(name: str, kind: str, span: Span) -> Diagnostic:
    """A call of another ``kind`` of declaration (``a const``)."""
    return Diagnostic("E0204", f"'{name}' is {kind}, not a function", span, f"index arrays: {name}[..]")


def _other_quantifier(name: str) -> str:
    """Return how this language writes another one's quantifier, an empty string for other words."""
    own = FOREIGN_FUNCTIONS.get(name.lower())
    return f"write {own}" if own else ""


def unknown_quantifier(name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A word before ``(i in T: ..)`` that is none of the ``known`` quantifiers."""
    remedy = _other_quantifier(name) or did_you_mean(name, known) or f"use one of {', '.join(sorted(known))}"
    return Diagnostic("E0204", f"'{name}' cannot run over values", span, remedy)


def unknown_field(record: Record | str, field: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A field that a record lacks."""
    remedy = did_you_mean(field, known) or f"its fields are {', '.join(known)}"
    return Diagnostic("E0205", f"record '{record}' has no field '{field}'", span, remedy)


def unknown_variant(enum: Enum, name: str, span: Span) -> Diagnostic:
    """A variant that an enum lacks."""
    names = [v.name for v in enum.variants]
    remedy = did_you_mean(name, names) or f"its variants are {', '.join(names)}"
    return Diagnostic("E0205", f"enum '{enum}' has no variant '{name}'", span, remedy)


def unknown_member(
    element: str, name: str, known: Iterable[str], other: str | None, span: Span
) -> Diagnostic:
    """A variable or let that an element lacks; ``other`` is what an element called ``name`` has, if any."""
    remedy = did_you_mean(name, known) or f"declare it in element {element}"
    if other is not None:
        remedy = f"'{name}' is an element itself: read one of its variables, as in {other}"
    return Diagnostic("E0205", f"element '{element}' has no variable or let '{name}'", span, remedy)


def no_members(field: str, found: Type, operand: str, span: Span) -> Diagnostic:
    """A field of a value without fields; ``operand`` is how the value is written, ``..`` for the long."""
    is_variant = isinstance(found, Enum) and found.variant(field) is not None
    return Diagnostic(
        "E0205",
        f"this has no field '{field}': it is {described(found)}",
        span,
        f"write {operand} == {field}" if is_variant else "only elements, records and enums have members",
    )


def ambiguous_variant(name: str, owners: Sequence[str], span: Span) -> Diagnostic:
    """A variant that several enums have."""
    message = f"'{name}' is a variant of {' and of '.join(owners)}"
    return Diagnostic("E0206", message, span, f"say which: {owners[0]}.{name}")


def not_a_type(name: str, span: Span) -> Diagnostic:
    """Another declaration where a type is needed."""
    return Diagnostic("E0207", f"'{name}' is not a type", span, "name a type, an enum or a record here")


def not_a_value(name: str, kind: str, span: Span) -> Diagnostic:
    """Another ``kind`` of declaration (``a type``) where a value is needed."""
    remedy = "name a value here"
    if kind in ("a type", "an enum"):
        remedy += f"; a draw of any of its values is uniform({name})"
    return Diagnostic("E0207", f"'{name}' is {kind}, not a value", span, remedy)


def element_as_value(name: str, is_family: bool, primed: bool, span: Span) -> Diagnostic:
    """An element where a value is needed."""
    member = f"{name}[..]" if is_family else name
    remedy = f"read one of its variables: {member}.x"
    if primed:
        remedy = f"the prime stands behind the variable: {member}.x'"
    return Diagnostic("E0207", f"'{name}' is an element, not a value", span, remedy)


def member_as_value(family: str, primed: bool, span: Span) -> Diagnostic:
    """A member of a family of elements where a value is needed."""
    remedy = f"read one of its variables: {family}[..].x"
    if primed:
        remedy = f"the prime stands behind the variable: {family}[..].x'"
    return Diagnostic("E0207", "a member of a family is not a value", span, remedy)


def function_as_value(name: str, span: Span) -> Diagnostic:
    """A function without arguments."""
    return Diagnostic("E0207", f"'{name}' is a function", span, f"call it: {name}(..)")


def function_as_array(name: str, span: Span) -> Diagnostic:
    """A function with its arguments in brackets."""
    return Diagnostic("E0207", f"'{name}' is a function", span, "call it with (..)")


def observation_in_model(name: str, span: Span) -> Diagnostic:
    """An observation that the model itself reads."""
    message = f"'{name}' is an observation, which the model cannot read"
    remedy = "read the variables it depends on, or make it a visible variable"
    return Diagnostic("E0207", message, span, remedy)


def observation_in_policy(name: str, span: Span) -> Diagnostic:
    """An observation that the policy reads before it is made."""
    message = f"'{name}' is an observation, which comes only after the policy has chosen"
    return Diagnostic("E0207", message, span, "write last(.., first) for what was seen in the step before")


def last_of_nameless(form: str, span: Span) -> Diagnostic:
    """``last`` of an expression that is no name; ``form`` is how ``last`` is written."""
    message = "'last' is asked for something without a name"
    return Diagnostic("E0207", message, span, f"its form is {form}; memory keeps other things")


def last_of_other(name: str, kind: str, form: str, span: Span) -> Diagnostic:
    """``last`` of another ``kind`` of declaration (``a const``)."""
    message = f"'{name}' is {kind}, not an observation"
    return Diagnostic("E0207", message, span, f"its form is {form}; memory keeps other things")


def last_of_unknown(name: str, known: Iterable[str], form: str, span: Span) -> Diagnostic:
    """``last`` of a name that nothing declares; ``known`` are the observations and the action."""
    message = f"'{name}' is neither an observation nor the action"
    known = list(known)
    owned = next((path for path in known if path.rpartition(".")[2] == name), None)
    remedy = did_you_mean(name, known) or f"its form is {form}; memory keeps other things"
    if owned is not None:
        remedy = f"write its whole name: last({owned}, first)"
    return Diagnostic("E0207", message, span, remedy)


def circular_declaration(cycle: Sequence[tuple[str, Span]]) -> Diagnostic:
    """Declarations that need each other: each with its place, the first one needed by the last."""
    name, span = cycle[0]
    return Diagnostic(
        "E0208",
        f"{name} is defined by itself: {' -> '.join([*(n for n, _ in cycle), name])}",
        span,
        "break the circle: what one of them needs must not come from itself",
        tuple((s, f"{n} is declared here") for n, s in cycle[1:]),
    )


def endless_recursion(name: str, why: str, span: Span, declared: Span) -> Diagnostic:
    """A function's call of itself that may go on for ever; ``why`` is a clause about the call."""
    return Diagnostic(
        "E0209",
        f"'{name}' calls itself, and nothing shows that this ends: the call {why}",
        span,
        "give each call an int that is constant and lower than before: if n == 0 then .. else f(n - 1)",
        ((declared, f"'{name}' is declared here"),),
    )


def deep_recursion(name: str, most_calls: int, most_copies: int, span: Span) -> Diagnostic:
    """A function that calls itself more often than the checks follow."""
    return Diagnostic(
        "E0210",
        f"'{name}' calls itself too often: more than {most_calls} times in a row, or with more than "
        f"{most_copies} different constants",
        span,
        "start from a smaller number, or use sum, min, max or a table",
    )
