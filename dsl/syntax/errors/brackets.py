# SPDX-License-Identifier: Apache-2.0
"""Syntax mistakes inside brackets: binders of quantifiers, and values of records."""

from __future__ import annotations

import re

from lark import Token

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import Situation, shown
from hypgen.dsl.types import builtin_names

_OVER_SETS = builtin_names.QUANTIFIERS | {"uniform", "weighted"}
_TYPE_WORDS = ("BOOL", "INT_TYPE", "FLOAT_TYPE", "PROB")
_OPERAND_STARTS = ("NAME", "INT", "FLOAT", "LPAR", "IF", "MATCH", "TRUE", "FALSE")


def _foreign_binder(s: Situation) -> Diagnostic | None:
    """Know `sum(T i: e)`, `sum(T where c)`, `sum(i: T: e)`, `sum(T: e)`, `sum(int i = 0 ..)`.

    Know `sum(i = 0 ..)`, too.
    """
    opened = s.open_bracket
    if opened is None:
        return None
    if s.follows("ELEMENT", "NAME", "LSQB", "NAME") and s.token.type in ("NAME", "RSQB"):
        return _family_without_name(s)
    quantifier, inside = _called(s, opened), _inside(s, opened)
    starts = opened.type == "LSQB" if quantifier is None else quantifier in _OVER_SETS
    if not starts or len(inside) > 1 or (inside and inside[0].type != "NAME"):
        return None
    if not inside:
        named = re.match(r"\w+\s+([a-z]\w*)\s*[=:]", s.rest)
        written = None if named is None or s.token.type not in _TYPE_WORDS else f"{named[1]} in Type"
    elif s.token.type == "NAME" and re.match(r"\w+\s*(:|where\b)", s.rest):
        written = f"{s.token} in {inside[0]}"
    elif s.token.type == "WHERE":
        written = f"i in {inside[0]} where condition of i"
    elif s.token.type == "EQUAL" and ".." in s.rest.split("\n")[0]:
        written = f"{inside[0]} in low .. high"
    elif s.token.type == "COLON" and "IN" in s.accepts:
        own = re.match(r":\s*(\w+)\s*(:|where\b)", s.rest)
        is_type = own is None and inside[0][:1].isupper()
        written = f"i in {inside[0]}" if is_type else f"{inside[0]} in {own[1] if own else 'Type'}"
    else:
        written = None
    if written is None:
        return None
    at = s.span() if not inside else s.span(inside[0]).to(s.span())
    form = f"[{written}: ..]" if quantifier is None else f"{quantifier}({written}: ..)"
    what = "a comprehension" if quantifier is None else f"'{quantifier}'"
    return Diagnostic("E0145", f"what {what} runs over is written `name in Type`", at, f"write `{form}`")


def _family_without_name(s: Situation) -> Diagnostic:
    type_, element = s.previous(), s.previous(3)
    member = s.token if s.token.type == "NAME" else "i"
    at = s.span(type_).to(s.span()) if s.token.type == "NAME" else s.span(type_)
    remedy = f"write `element {element}[{member} in {type_}]`"
    return Diagnostic("E0145", "what a family runs over is written `name in Type`", at, remedy)


def _misplaced_body(s: Situation) -> Diagnostic | None:
    """Know `sum(i in T if c: e)`, `sum(i in T, e)` and `sum(i in T) e`."""
    closed = s.previous()
    if closed is not None and closed.type == "RPAR" and s.token.type in _OPERAND_STARTS and not s.on_new_line:
        opened = _opener(s.before)
        inside = s.before[:-1] if opened is None else _between(s, opened, closed)
        quantifier = None if opened is None else _called(s, opened)
        if quantifier not in builtin_names.QUANTIFIERS or not _is_binder(inside) or "COLON" in _types(inside):
            return None
        remedy = f"write `{quantifier}({_text(s, inside)}: ..)`"
        return Diagnostic("E0145", f"what '{quantifier}' is of stands in its parentheses", s.span(), remedy)
    opened = s.open_bracket
    if opened is None:
        return None
    inside = _inside(s, opened)
    if not _is_binder(inside) or "COLON" in _types(inside):
        return None
    quantifier = _called(s, opened)
    before, after = (f"{quantifier}(", ")") if quantifier else ("[", "]")
    if s.token.type == "IF" and "WHERE" in s.accepts:
        remedy = f"write `{before}{_text(s, inside)} where condition: ..{after}`"
        return Diagnostic("E0145", "a condition on what is run over follows 'where'", s.span(), remedy)
    comma = max((n for n, t in enumerate(inside) if t.type == "COMMA"), default=None)
    if comma is None or "IN" in _types(inside[comma:]) or not s.accepts <= {"NAME", "IN"}:
        return None
    first = inside[comma + 1] if comma + 1 < len(inside) else s.token
    remedy = f"write `{before}{_text(s, inside[:comma])}: ..{after}`"
    message = f"after this ',' stands another `name in Type`; found {shown(first)}"
    return Diagnostic("E0145", message, s.span(first), remedy)


def _foreign_record(s: Situation) -> Diagnostic | None:
    """Know `P {x: 1}`, `P(x = 1)`, `P(x: 1)` and `(1, 2)`."""
    name, opened = s.previous(), s.open_bracket
    if s.token.type == "LBRACE" and name is not None and name.type == "NAME" and not s.on_new_line:
        fields = names_of(s, str(name))
        if fields is None or s.follows("RECORD", "NAME"):
            return None
        message = f"the record '{name}' is built with parentheses, its fields in order"
        inside = s.source.text[s.token.end_pos :].replace("}", ")", 1)
        values = _in_order(inside, fields.split(", ")) or fields
        return Diagnostic("E0146", message, s.span(name).to(s.span()), f"write `{name}({values})`")
    if opened is None or opened.type != "LPAR":
        return None
    called = _called(s, opened)
    if s.token.type in ("EQUAL", "COLON") and called is not None and name is not None and name.type == "NAME":
        fields = names_of(s, called)
        before = s.previous(2)
        if fields is None or before is None or before.type not in ("LPAR", "COMMA"):
            return None
        if name not in fields.split(", "):
            return None
        message = f"'{called}' takes its values in order, without names"
        values = _in_order(s.source.text[opened.end_pos :], fields.split(", ")) or fields
        return Diagnostic("E0146", message, s.span(name).to(s.span()), f"write `{called}({values})`")
    if s.token.type == "COMMA" and called is None and s.accepts & {"RPAR"}:
        remedy = "write `Name(a, b)` for a record, or `[a, b]` for an array"
        return Diagnostic("E0146", "parentheses hold one value", s.span(), remedy)
    return None


def _inside(s: Situation, opened: Token) -> tuple[Token, ...]:
    """Return the tokens from an open bracket to where the parser gave up."""
    return tuple(t for t in s.before if (t.start_pos or 0) > (opened.start_pos or 0))


def _between(s: Situation, opened: Token, closed: Token) -> tuple[Token, ...]:
    return tuple(t for t in _inside(s, opened) if (t.start_pos or 0) < (closed.start_pos or 0))


def _opener(tokens: tuple[Token, ...]) -> Token | None:
    """Return what the last token, a `)`, closes."""
    depth = 0
    for token in reversed(tokens):
        depth += (token.type == "RPAR") - (token.type == "LPAR")
        if depth == 0:
            return token
    return None


def _called(s: Situation, opened: Token) -> str | None:
    """Return the name right before a bracket, if it opens a call."""
    touching = next((t for t in s.before if t.end_pos == opened.start_pos), None)
    is_call = opened.type == "LPAR" and touching is not None and touching.type == "NAME"
    return str(touching) if is_call else None


def _is_binder(tokens: tuple[Token, ...]) -> bool:
    return len(tokens) > 2 and tokens[0].type == "NAME" and tokens[1].type == "IN"


def _types(tokens: tuple[Token, ...]) -> list[str]:
    return [t.type for t in tokens]


def _text(s: Situation, tokens: tuple[Token, ...]) -> str:
    return s.source.text[tokens[0].start_pos : tokens[-1].end_pos]


def names_of(s: Situation, name: str) -> str | None:
    """Return the fields of a record or the formals of a function of this file, None if there is none."""
    found = re.search(rf"\b(?:record\s+{name}\s*\{{([^}}]*)\}}|fn\s+{name}\s*\(([^)]*)\))", s.source.text)
    if found is None:
        return None
    chunks = (found[1] or found[2] or "").split(":")[:-1]
    names: list[str] = []
    for number, chunk in enumerate(chunks):  # beyond the first, each begins with the type before it
        rest = re.sub(r"^\s*\w+", "", chunk) if number else chunk
        own = re.search(r"[A-Za-z_]\w*(?:\s*,\s*[A-Za-z_]\w*)*\s*$", rest)
        names += re.findall(r"\w+", own[0]) if own else []
    return ", ".join(names)


def _in_order(text: str, fields: list[str]) -> str | None:
    """Return the values of ``x: 1, y: 2)`` in the order of the fields, None if that is not all of them."""
    given = dict(re.findall(r"(\w+)\s*[:=]\s*([^,()\n]+)", text.split(")")[0]))
    return ", ".join(given[f].strip() for f in fields) if given.keys() == set(fields) else None


def _braces_of_fields(s: Situation) -> Diagnostic | None:
    """Know `{ x = 0, y = 0 }`, where a record is built."""
    opened, name = s.open_bracket, s.previous()
    if s.token.type != "EQUAL" or opened is None or opened.type != "LBRACE" or name is None:
        return None
    inside = _inside(s, opened)
    at = next(n for n, t in enumerate(s.before) if t is opened)
    if len(inside) != 1 or name.type != "NAME" or s.before[at - 1].type not in _BEFORE_RECORDS:
        return None
    records = re.findall(r"\brecord\s+(\w+)", s.source.text)
    record = next((r for r in records if str(name) in (names_of(s, r) or "").split(", ")), None)
    fields = None if record is None else names_of(s, record)
    values = (
        ""
        if fields is None
        else _in_order(s.source.text[opened.end_pos :].replace("}", ")"), fields.split(", "))
    )
    remedy = f"write `{record or 'Name'}({values or fields or 'a, b'})`, its fields in order"
    return Diagnostic("E0146", "a record is built by its name and parentheses", s.span(opened), remedy)


_BEFORE_RECORDS = ("EQUAL", "TILDE", "THEN", "ELSE", "COLON", "COMMA", "LPAR", "LBRACE", "_ARROW")


BRACKET_MISTAKES = (_foreign_binder, _misplaced_body, _foreign_record, _braces_of_fields)
