# SPDX-License-Identifier: Apache-2.0
"""Texts of E0309, E0311 and E0312: arrays, lists, grids and records that are written as what they are not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import given
from hypgen.dsl.types import Bool, Enum, Type, size_of

_INDEX_NAMES = "ijklmnpqrstuvw"


def array_for_value(name: str, element: Type, span: Span) -> Diagnostic:
    """An array where one value is asked for."""
    message = f"'{name}' takes one value here, not an array"
    return Diagnostic("E0309", message, span, f"give a value of type {element}")


def one_string_for_grid(name: str, indices: Sequence[Type], span: Span) -> Diagnostic:
    """One string where a grid has several rows."""
    *above, last = map(size_of, indices)
    message = f"'{name}' is a grid of {' by '.join(map(str, above))} rows"
    return Diagnostic("E0309", message, span, f"give a list of strings, each of {last} glyphs")


def wrong_length(name: str, index: Type, has: int, span: Span) -> Diagnostic:
    """A list of another length than its index type has values."""
    message = f"'{name}' takes {size_of(index)} entries, but {given(has)}"
    return Diagnostic("E0309", message, span, f"give one for each value of {index}")


def value_for_array(name: str, indices: Sequence[Type], span: Span) -> Diagnostic:
    """One value where an array is asked for."""
    wanted = " by ".join(str(size_of(i)) for i in indices)
    message = f"'{name}' is an array of {wanted} entries"
    return Diagnostic("E0309", message, span, "write [a, b, ..] or [i in T: e]")


def other_indexes(name: str, indices: Sequence[Type], span: Span) -> Diagnostic:
    """A comprehension over other types than the array's indexes."""
    wanted = ", ".join(f"{b} in {t}" for b, t in zip(_INDEX_NAMES, indices, strict=False))
    message = f"'{name}' is indexed by {', '.join(map(str, indices))}"
    return Diagnostic("E0309", message, span, f"write [{wanted}: ..]")


def wrong_number_listed(name: str, takes: int, has: int, span: Span) -> Diagnostic:
    """Strings that list another number of entries than the array has."""
    message = f"'{name}' takes {takes} entries, but {has} {'is' if has == 1 else 'are'} listed"
    return Diagnostic("E0309", message, span, "give one for each value of its indexes, in order")


def wrong_number_of_glyphs(name: str, index: Type, has: int, span: Span) -> Diagnostic:
    """A row of a grid of another length than its index type has values."""
    message = f"'{name}' takes {size_of(index)} glyphs here, but the string has {has}"
    return Diagnostic("E0309", message, span, f"give one for each value of {index}")


def array_in_expression(span: Span) -> Diagnostic:
    """A list within an expression."""
    message = "an array is not a value of an expression"
    return Diagnostic("E0309", message, span, "declare it as a const or param and read its entries")


def unknown_entry(word: str, element: Type, known: Iterable[str], span: Span) -> Diagnostic:
    """A word of a string that is no value of the array's entries; ``known`` are those with a name."""
    remedy = "a string lists numbers, separated by blanks"
    if isinstance(element, Enum):
        remedy = "list the names of variants, separated by blanks"
        remedy += ', or give them glyphs, as in enum Cell { floor ".", wall "#" }'
        if not any(v.argument is None for v in element.variants):
            remedy = "write a list"
    elif isinstance(element, Bool):
        remedy = "list true and false, separated by blanks"
    kind = f"enum '{element}'" if isinstance(element, Enum) else f"'{element}'"
    return Diagnostic("E0311", f"'{word}' is no value of {kind}", span, did_you_mean(word, known) or remedy)


def string_beside_others(span: Span) -> Diagnostic:
    """A list of strings and of other entries."""
    message = "strings stand beside other entries here"
    return Diagnostic("E0311", message, span, "write all entries in strings, or none")


def string_in_expression(text: str, span: Span) -> Diagnostic:
    """A string within an expression."""
    message = "a string is a row of a grid, and one value is asked for here"
    remedy = f"a variant of an enum has no quotes: {text}"
    if not text.isidentifier():
        remedy = "write grids of glyphs as the value of a const or param that is an array"
    return Diagnostic("E0311", message, span, remedy)


def unknown_glyph(enum: Enum, glyph: str, span: Span) -> Diagnostic:
    """A character of a grid that no variant has."""
    known = ", ".join(f"'{g}' {v.name}" for v in enum.variants if (g := v.glyph) is not None)
    other = next((g for g in enum.glyphs if g.lower() == glyph.lower()), None)
    remedy = f"did you mean '{other}'?" if other is not None else f"its glyphs are {known}"
    return Diagnostic("E0311", f"enum '{enum}' has no glyph '{glyph}'", span, remedy)


def record_for_value(found: str, fields: Sequence[str], span: Span) -> Diagnostic:
    """A record, ``found`` in words, where one value is asked for; ``fields`` are its leaves."""
    message = f"one value is needed here, but this is {found}"
    return Diagnostic("E0311", message, span, f"take one of its parts: .{' or .'.join(fields)}")


def record_needed(wanted: str, found: str, form: str, span: Span) -> Diagnostic:
    """Another value where a record is asked for; both in words, ``found`` empty where it is not known."""
    message = f"{wanted} is needed here" + (f", but this is {found}" if found else "")
    return Diagnostic("E0311", message, span, f"write {form}")


def long_glyph(variant: str, length: int, span: Span) -> Diagnostic:
    """A glyph of several characters, or none."""
    message = f"the glyph of '{variant}' has {length} characters"
    return Diagnostic("E0312", message, span, "a glyph is one character")


def glyph_with_argument(variant: str, span: Span) -> Diagnostic:
    """A glyph of a variant with an argument."""
    message = f"'{variant}' has an argument, which no glyph tells"
    return Diagnostic("E0312", message, span, "remove the glyph, or make a variant of each argument")


def same_glyph(variant: str, other: str, span: Span, other_span: Span) -> Diagnostic:
    """A glyph that another variant has already."""
    return Diagnostic(
        "E0312",
        f"'{variant}' and '{other}' have the same glyph",
        span,
        "give each variant a glyph of its own",
        ((other_span, f"'{other}' has it already"),),
    )
