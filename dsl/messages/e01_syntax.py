# SPDX-License-Identifier: Apache-2.0
"""Texts of E01xx that no rule of ``dsl/syntax/errors`` gives.

Each rule there knows one way in which a file fails to parse, and holds its own text and remedy. Here are the
mistakes that a parsed file can have, files in other formats, and files that are too long or too deep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types.builtin_names import FOREIGN_FUNCTIONS

CASSANDRA = "E0130"
POMDPX = "E0131"
_IMPORT = (
    "`hypgen import FILE -o NEW.pomdp` writes it as a model of this language; "
    "run, sim, compile and the like take the file as it is"
)


def cassandra_file(span: Span) -> Diagnostic:
    """A file in Cassandra's format, recognised by its first words."""
    message = "this is a file in Cassandra's POMDP format (flat lists of states and numbers)"
    return Diagnostic(CASSANDRA, message, span, _IMPORT)


def pomdpx_file(span: Span) -> Diagnostic:
    """A file in POMDPX, recognised by its elements."""
    return Diagnostic(POMDPX, "this is a POMDPX file (XML)", span, _IMPORT)


def xml_file(span: Span) -> Diagnostic:
    """An XML file whose beginning does not say which it is."""
    remedy = "POMDPX has the element <pomdpx>; `hypgen import FILE -o NEW.pomdp` makes a model of it"
    return Diagnostic(POMDPX, "this is an XML file, and no model", span, remedy)


def named_foreign_file(found: Diagnostic, path: str, cited: Span) -> Diagnostic:
    """A file in another format that an instance or an import names; ``found`` says which format."""
    remedy = f"write it as a model, `hypgen import {path} -o NEW.pomdp`, and name that"
    return replace(found, remedy=remedy, notes=((cited, "it is named here"),))


def too_deep(most: int, span: Span) -> Diagnostic:
    """An expression of more levels than the checks can walk."""
    message = f"this is nested more than {most} levels deep (an operator is a level)"
    remedy = "name a part of it with `fn` or `let`, or run over values with `sum`, `any` or `all`"
    return Diagnostic("E0135", message, span, remedy)


def number_too_large(span: Span) -> Diagnostic:
    """A number that neither an int nor a float can hold."""
    remedy = "integers have 32 bits and other numbers are float32: choose a larger unit"
    return Diagnostic("E0136", "this number is too large", span, remedy)


def unknown_quantifier(name: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A word before ``(i in T: ..)`` that is none of the ``known`` quantifiers."""
    own = FOREIGN_FUNCTIONS.get(name.lower())
    remedy = f"write {own}" if own else did_you_mean(name, known) or "use one of " + " ".join(known)
    return Diagnostic("E0137", f"'{name}' cannot run over values", span, remedy)


def missing_body(quantifier: str, span: Span) -> Diagnostic:
    """A quantifier that has binders and nothing behind them."""
    message = f"'{quantifier}' says over what it runs but not of what"
    remedy = f"write what after a colon, as in `{quantifier}(r in Rock: value[r])`"
    return Diagnostic("E0138", message, span, remedy)


def foreign_to_library(what: str, span: Span) -> Diagnostic:
    """A part of a model, ``what`` in words, within a library."""
    remedy = "move it to the model; a library has const, type, enum, record, fn and import"
    return Diagnostic("E0139", f"a library cannot have {what}", span, remedy)


def unknown_moment(words: str, span: Span) -> Diagnostic:
    """Words between an observation's type and its law that are not ``at start``."""
    message = f"'{words}' is no time to observe at"
    remedy = "write 'at start' for what is seen before the first action, and nothing for what each step shows"
    return Diagnostic("E0151", message, span, remedy)


def first_look_outside_element(name: str, span: Span) -> Diagnostic:
    """An ``observe .. at start`` that stands in no element."""
    message = f"what is seen at the start stands in an element: '{name}' stands outside"
    remedy = f"move it into the element that it tells of; others then read it as element.{name}"
    return Diagnostic("E0152", message, span, remedy)


def too_long(most: int, span: Span) -> Diagnostic:
    """A file of more than ``most`` tokens."""
    message = f"the file is too long: it has more than {most} words, numbers and signs"
    remedy = "declare large tables as params without a value, and give them in a file of params"
    return Diagnostic("E0140", message, span, remedy)


def record_in_braces(record: str, fields: Sequence[str], span: Span) -> Diagnostic:
    """A record's value that is written as a struct of other languages, ``{x: 1, y: 2}``."""
    message = f"braces are a table of probabilities, and a value of '{record}' is built with parentheses"
    return Diagnostic("E0146", message, span, f"write `{record}({', '.join(fields)})`, its fields in order")


def several_indexes(family: str, indexes: Sequence[tuple[str, str]], span: Span) -> Diagnostic:
    """A family with more than one index; ``indexes`` are their names and types."""
    message = f"the family '{family}' has one index: this is a second one"
    fields = "  ".join(f"{name}: {t}" for name, t in indexes)
    remedy = f"index it by a record: record Place {{ {fields} }}   element {family}[p in Place]"
    return Diagnostic("E0153", message, span, remedy)
