# SPDX-License-Identifier: Apache-2.0
"""Syntax mistakes in `e is variant`, `p with { x = 1 }` and `{ a: p, else b }`."""

from __future__ import annotations

import re

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import Situation


def _value_behind_is(s: Situation) -> Diagnostic | None:
    """Know `act is go(2)`, `act is not go` and `x is 3`."""
    if s.token.type == "LPAR" and s.follows("IS", "NAME"):
        message = "'is' asks for a variant of any value"
        remedy = f"write `is {s.previous()}` alone, or compare with one value: `== {s.previous()}(..)`"
        return Diagnostic("E0154", message, s.span(), remedy)
    if not s.follows("IS") or s.token.type == "NAME":
        return None
    if s.token.type == "NOT":
        variant = re.match(r"not\s+(\w+)", s.rest)
        remedy = f"write `not (value is {variant[1] if variant else 'variant'})`"
        return Diagnostic("E0154", "'not' stands before the whole test", s.span(), remedy)
    message = "'is' asks for a variant by its name"
    return Diagnostic("E0154", message, s.span(), "write `==` to compare values")


def _fields_behind_with(s: Situation) -> Diagnostic | None:
    """Know `p with (x = 1)` and `p with { x: 1 }`."""
    if s.follows("WITH") and s.token.type != "LBRACE":
        remedy = "write `value with { field = new }`"
        return Diagnostic("E0154", "what 'with' changes stands in braces", s.span(), remedy)
    if s.token.type != "COLON" or s.accepts != {"EQUAL"} or s.open_bracket is None:
        return None
    opened = next(n for n, t in enumerate(s.before) if t is s.open_bracket)
    if s.before[opened - 1].type != "WITH":
        return None
    remedy = f"write `{s.previous()} = ..`"
    return Diagnostic("E0154", "'with' gives a field its new value by '='", s.span(), remedy)


def _colon_behind_else(s: Situation) -> Diagnostic | None:
    """Know `{ a: 0.5, else: b }`."""
    if s.token.type != "COLON" or not s.follows("ELSE") or s.open_bracket is None:
        return None
    message = "the value of the rest follows 'else' without a ':'"
    return Diagnostic("E0154", message, s.span(), "write `else value`: it takes the probability that is left")


def record_behind_bar(s: Situation) -> Diagnostic | None:
    """Know `{ p | x = 1 }`."""
    within = re.match(r"\|\s*(\w+)\s*(=|:|->|<-)", s.rest)
    return _changed(s, f"{s.previous()}", within[1]) if within and s.follows("LBRACE", "NAME") else None


def braces_behind_value(s: Situation) -> Diagnostic | None:
    """Know `P(0, 0) { x = 1 }` and `p { x = 1 }`."""
    value, behind = s.previous(), re.match(r"\{\s*(\w+)\s*=[^=]", s.rest)
    if value is None or behind is None or value.type not in ("NAME", "RPAR", "RSQB") or s.on_new_line:
        return None
    if s.expects_expression or not any(t.type in ("EQUAL", "TILDE") for t in s.before[-12:]):
        return None
    return _changed(s, "value", behind[1])


def _changed(s: Situation, value: str, field: str) -> Diagnostic:
    remedy = f"write `{value} with {{ {field} = .. }}`"
    return Diagnostic("E0154", "a record with other fields is written by 'with'", s.span(), remedy)


SMALL_FORM_MISTAKES = (_value_behind_is, _fields_behind_with, _colon_behind_else)
