# SPDX-License-Identifier: Apache-2.0
"""Texts of E0302 and E0303: calls with the wrong arguments, and indexes that do not fit."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import counted, described, given
from hypgen.dsl.types import Bool, Enum, Int, Record, Type

AT_FORM = "its form is at(array, index, .., default)"


def wrong_arguments(name: str, takes: int, has: int, form: str, span: Span) -> Diagnostic:
    """A call with another number of arguments than the function takes; ``form`` is how it is written."""
    message = f"'{name}' takes {counted(takes, 'argument')}, but {given(has)}"
    return Diagnostic("E0302", message, span, f"its form is {form}")


def wrong_arguments_of_draw(name: str, takes: tuple[int, ...], has: int, form: str, span: Span) -> Diagnostic:
    """A built-in draw with another number of arguments than those that it takes."""
    message = f"'{name}' takes {' or '.join(map(str, takes))} argument{'' if takes == (1,) else 's'}"
    return Diagnostic("E0302", f"{message}, but {given(has)}", span, f"its form is {form}")


def wrong_arguments_of_builtin(name: str, has: int, form: str, span: Span) -> Diagnostic:
    """A built-in function with a number of arguments that it does not take."""
    message = f"'{name}' is given {counted(has, 'argument')}"
    return Diagnostic("E0302", message, span, f"its form is {form}")


def wrong_arguments_of_range_call(name: str, has: int, span: Span) -> Diagnostic:
    """``clamp``, ``wrap`` or ``checked`` with neither no ends nor both."""
    message = f"'{name}' takes 1 argument or 3, here {has}"
    return Diagnostic("E0302", message, span, f"its form is {name}(x) or {name}(x, low, high)")


def wrong_fields(record: str, takes: int, has: int, form: str, span: Span) -> Diagnostic:
    """A record's value with another number of fields than the record has."""
    message = f"'{record}' takes {takes} values, but {given(has)}"
    return Diagnostic("E0302", message, span, f"its form is {form}")


def wrong_arguments_of_belief(function: str, has: int, form: str, span: Span) -> Diagnostic:
    """``belief`` or ``deviation`` with another number of arguments than one."""
    return Diagnostic("E0302", f"'{function}' takes 1 argument, here {has}", span, f"its form is {form}")


def wrong_arguments_of_last(has: int, form: str, span: Span) -> Diagnostic:
    """``last`` with another number of arguments than two."""
    remedy = f"its form is {form}, with what stands in before the first step"
    return Diagnostic("E0302", f"'last' takes 2 arguments, here {has}", span, remedy)


def few_arguments_of_at(span: Span) -> Diagnostic:
    """``at`` without an index or a default."""
    return Diagnostic("E0302", "'at' takes at least 3 arguments", span, AT_FORM)


def without_binder(
    quantifier: str,
    array: tuple[str, Sequence[Type]] | None,
    span: Span,
    family: str | None = None,
) -> Diagnostic:
    """A quantifier that is called as a function.

    ``array``: the name and indexes of one that it is given. ``family``: over what the members of one run.
    """
    over, body = family or "i in T", ".."
    if array is not None:
        names = "ijklmnpqrstuvw"[: len(array[1])]
        over = ", ".join(f"{i} in {t}" for i, t in zip(names, array[1], strict=False))
        body = f"{array[0]}[{', '.join(names)}]"
    remedy = f"write {quantifier}({over}{' where ' if quantifier == 'count' else ': '}{body})"
    return Diagnostic("E0302", f"'{quantifier}' runs over the values of a type", span, remedy)


def count_with_body(span: Span) -> Diagnostic:
    """``count`` with something behind a colon."""
    return Diagnostic("E0302", "'count' has no body", span, "write count(i in T where condition)")


def without_body(quantifier: str, span: Span) -> Diagnostic:
    """A quantifier with nothing behind a colon."""
    return Diagnostic("E0302", f"'{quantifier}' needs a body", span, f"write {quantifier}(i in T: ..)")


def needless_else(quantifier: str, span: Span) -> Diagnostic:
    """``else`` in a quantifier whose value over nothing is known."""
    message = f"'{quantifier}' of nothing is known: it takes no 'else'"
    return Diagnostic("E0302", message, span, "remove it")


def several_binders(quantifier: str, span: Span) -> Diagnostic:
    """``argmin`` or ``argmax`` over several names."""
    return Diagnostic("E0302", f"'{quantifier}' runs over one type", span, "bind one name")


def variant_takes_argument(name: str, argument: Type, span: Span) -> Diagnostic:
    """A variant without the argument that it takes."""
    message = f"variant '{name}' takes an argument of type {argument}"
    remedy = f"give it one, {name}({_example(argument)}); or ask whether it is any {name}: value is {name}"
    return Diagnostic("E0302", message, span, remedy)


def _example(t: Type) -> str:
    """Return a value of a finite type, as far as it is short to write."""
    match t:
        case Enum():
            first = t.variants[0]
            return first.name if first.argument is None else f"{first.name}({_example(first.argument)})"
        case Int():
            return str(t.low)
        case Bool():
            return "true"
    return "value"


def variant_takes_none(name: str, span: Span) -> Diagnostic:
    """A variant with an argument that it does not take."""
    return Diagnostic("E0302", f"variant '{name}' takes no argument", span, f"write {name} alone")


def wrong_indexes(label: str, takes: int, has: int, remedy: str, span: Span) -> Diagnostic:
    """A read with another number of indexes than what is read has."""
    wanted = "no index" if takes == 0 else "one index" if takes == 1 else f"{takes} indexes"
    return Diagnostic("E0303", f"'{label}' takes {wanted}, here given {has}", span, remedy)


def wrong_indexes_of_at(label: str, takes: Sequence[Type], has: int, span: Span) -> Diagnostic:
    """``at`` with another number of indexes than the array has."""
    wanted = ", ".join(map(str, takes))
    message = f"'{label}' is indexed by [{wanted}], here given {has}"
    remedy = AT_FORM
    if len(takes) == 1 and isinstance(takes[0], Record):
        names = ", ".join(name for name, _ in takes[0].fields)
        remedy = f"write at({label}, index, default), or its fields: at({label}, {names}, default)"
    return Diagnostic("E0303", message, span, remedy)


def at_of_other(span: Span) -> Diagnostic:
    """``at`` of what is no array."""
    return Diagnostic("E0303", "'at' reads an entry of an array, and this is none", span, AT_FORM)


def element_with_index(name: str, span: Span) -> Diagnostic:
    """An index behind an element that is no family."""
    return Diagnostic("E0303", f"'{name}' is one element", span, f"write {name}.name")


def family_without_index(name: str, binder: str, read: str, index: Type, has: int, span: Span) -> Diagnostic:
    """A family of elements without the index of a member; ``read`` is what is asked of it: ``at'``."""
    if has and isinstance(index, Record):
        fields = ", ".join(field for field, _ in index.fields)
        message = f"'{name}' has one index, a {index}, here given {has}"
        return Diagnostic("E0303", message, span, f"write {name}[{index}({fields})].{read}")
    message = f"'{name}' is a family: say which member"
    return Diagnostic("E0303", message, span, f"write {name}[{binder}].{read} of a member {binder}")


def twice_indexed(name: str, index: Type, span: Span) -> Diagnostic:
    """A family of elements with a second index in brackets of its own."""
    form = f"{index}({', '.join(f for f, _ in index.fields)})" if isinstance(index, Record) else ".."
    message = f"'{name}' has one index, of type {index}"
    return Diagnostic("E0303", message, span, f"write {name}[{form}] and then one of its variables")


def not_indexable(found: Type, span: Span) -> Diagnostic:
    """An index behind a value."""
    message = f"this cannot be indexed: it is {described(found)}"
    return Diagnostic("E0303", message, span, "index arrays, and families of elements, only")


def field_of_record_array(record: str, field: str, span: Span) -> Diagnostic:
    """A field of an array of records, without an index."""
    message = f"this is an array of '{record}'"
    return Diagnostic("E0303", message, span, f"say which entry: name[..].{field}")
