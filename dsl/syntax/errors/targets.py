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
    parts = re.match(r"(?:\[[^\]\n]*\])?\s*\.\s*(\w+)(?:\s*\.\s*(\w+))?", s.rest)
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
    if parts[2] is not None and not init:
        written += f" = {parts[1]} with {{ {parts[2]} = .. }}"
    message = f"only the element that declares '{parts[1]}' defines it, and names it alone"
    return Diagnostic("E0143", message, s.span(name), f"write `{written}` in element '{name}'")


def _field_of_primed(s: Situation) -> Diagnostic | None:
    """Know `p'.x = 1`."""
    field = re.match(r"\.\s*(\w+)", s.rest)
    if field is None or not s.follows("NAME", "QUOTE") or s.accepts != {"EQUAL", "TILDE"}:
        return None
    name = s.previous(2)
    remedy = f"write `{name}' = {name} with {{ {field[1]} = .. }}`, which keeps its other fields"
    message = f"the record '{name}' is defined as a whole, not field by field"
    return Diagnostic("E0143", message, s.span(name), remedy)


def _next_value(s: Situation) -> Diagnostic | None:
    """Know `next x = ..`, `x next = ..`, `next(x) = ..`, `x(t+1) = ..` and `x[t + 1] = ..`."""
    word = s.previous()
    if word is None or word.type != "NAME":
        return None
    if s.accepts != {"QUOTE"}:
        if word != "next" or s.token.type != "NAME" or s.on_new_line:
            return None
        message = "the value after a step has a prime"
        return Diagnostic("E0143", message, s.span(word), f"write `{s.token}'`")
    sign = re.search(r"(?<![=<>!])[=~](?!=)", s.rest.split("\n")[0])
    called = re.match(r"[(\[]\s*(\w+)\s*([+][^)\]\n]*)?[)\]]", s.rest)
    if word == "next" and (s.token.type == "NAME" or called is not None):
        name, how = str(s.token) if called is None else called[1], "'next'"
    elif s.token == "next":
        name, how = str(word), "'next'"
    elif called is not None and called[2] is not None and called[1] in ("t", "time", "step", "k"):
        name, how = str(word), f"'{called[0]}'"
    else:
        return None
    message = f"the value after a step is named by a prime, not by {how}"
    return Diagnostic("E0143", message, s.span(word), f"write `{name}' {sign[0] if sign else '='} ..`")


def _indexed_target(s: Situation) -> Diagnostic | None:
    name = s.previous()
    if s.token.type != "LSQB" or name is None or name.type != "NAME":
        return None
    if s.accepts != {"QUOTE"} and not s.follows("INIT", "NAME"):
        return None
    left = f"init {name}" if s.follows("INIT", "NAME") else f"{name}'"
    element = max((n for n, t in enumerate(s.before) if t.type == "ELEMENT"), default=0)
    member, index = s.before[element + 2 : element + 4], re.match(r"\[\s*(\w+)\s*\]", s.rest)
    if len(member) > 1 and member[0].type == "LSQB" and index is not None and index[1] == member[1]:
        message = f"'{name}' is this member's variable, and is named alone"
        return Diagnostic("E0143", message, s.span(), f"write `{left} = ..`")
    remedy = f"write `{left} = [i in Type: expression of i]`"
    return Diagnostic(
        "E0128", f"the array '{name}' is defined as a whole, not entry by entry", s.span(), remedy
    )


TARGET_MISTAKES = (_next_value, _field_of_primed, _foreign_target, _indexed_target)
