# SPDX-License-Identifier: Apache-2.0
"""Syntax mistakes in what an init or update defines: `robot.x'`, `p.x'`, `x[0]'`, `next x`."""

from __future__ import annotations

import re

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.brackets import names_of
from hypgen.dsl.syntax.errors.situation import Situation


def _foreign_target(s: Situation) -> Diagnostic | None:
    """Know `init robot.x`, `robot.x'`, `init x'`, and `p.x'` of a record."""
    name, init = s.previous(), s.follows("INIT", "NAME")
    if name is None or name.type != "NAME" or not (init or s.accepts == {"QUOTE"}):
        return None
    if s.token.type == "QUOTE" and init:
        remedy = f"write `init {name}`"
        return Diagnostic("E0143", "an init has no prime: it is about the first state", s.span(), remedy)
    parts = re.match(r"(?:\[[^\]\n]*\])?\s*\.\s*(\w+)", s.rest)
    if parts is None:
        return None
    record = re.search(rf"\b(?:visible|hidden)\b[^\n:]*\b{name}\b[^\n:]*:\s*(\w+)", s.source.text)
    fields = None if record is None else names_of(s, record[1])
    left = f"init {name}" if init else f"{name}'"
    if record is not None and fields is not None:
        message = f"the record '{name}' is defined as a whole, not field by field"
        remedy = f"write `{left} = {name} with {{ {parts[1]} = .. }}`, which keeps its other fields"
        if init:
            values = ", ".join(".." for _ in fields.split(", "))
            remedy = f"write `{left} = {record[1]}({values})`, its fields in order"
        return Diagnostic("E0143", message, s.span(name), remedy)
    written = f"init {parts[1]}" if init else f"{parts[1]}'"
    message = f"only the element that declares '{parts[1]}' defines it, and names it alone"
    return Diagnostic("E0143", message, s.span(name), f"write `{written}` in element '{name}'")


def _next_value(s: Situation) -> Diagnostic | None:
    """Know `next x = ..`."""
    word = s.previous()
    if word != "next" or s.token.type != "NAME" or s.accepts != {"QUOTE"}:
        return None
    sign = re.match(r"\w+\s*(=|~)", s.rest)
    message = "the value after a step is named by a prime, not by 'next'"
    return Diagnostic("E0143", message, s.span(word), f"write `{s.token}' {sign[1] if sign else '='} ..`")


def _indexed_target(s: Situation) -> Diagnostic | None:
    name = s.previous()
    if s.token.type != "LSQB" or name is None or name.type != "NAME":
        return None
    if s.accepts != {"QUOTE"} and not s.follows("INIT", "NAME"):
        return None
    left = f"init {name}" if s.follows("INIT", "NAME") else f"{name}'"
    remedy = f"write `{left} = [i in Type: expression of i]`"
    return Diagnostic(
        "E0128", f"the array '{name}' is defined as a whole, not entry by entry", s.span(), remedy
    )


TARGET_MISTAKES = (_next_value, _foreign_target, _indexed_target)
