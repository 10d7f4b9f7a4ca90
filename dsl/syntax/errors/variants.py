# SPDX-License-Identifier: Apache-2.0
"""Syntax mistakes in what a variant of an enum carries: `move(Obj, Obj)`, `move(o: Obj)`, `move[Obj]`."""

from __future__ import annotations

import re

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import Situation

_CARRIED = re.compile(r"\s*(?:[(\[{][^()\[\]{}\n]*[)\]}]\s*)+")
_SIGNS = ("COLON", "COMMA", "LSQB", "LPAR", "LBRACE", "RPAR", "VBAR")
_NAMED = re.compile(r"(?:(\w+)\s*:\s*)?([\w .+*-]+?)\s*$")


def variant_value(s: Situation) -> Diagnostic | None:
    """Know a variant with several values, named ones, none in parentheses, and other brackets."""
    enum = next((n for n in range(len(s.before) - 1, -1, -1) if s.before[n].type == "ENUM"), None)
    if enum is None or len(s.before) < enum + 4 or s.before[enum + 2].type != "LBRACE":
        return None
    inside = s.before[enum + 3 :]
    if any(t.type == "RBRACE" for t in inside):
        return None
    start = depth = 0
    for n, token in enumerate(inside):
        depth += (token.type in ("LPAR", "LSQB")) - (token.type in ("RPAR", "RSQB"))
        start = n + 1 if token.type == "COMMA" and depth <= 0 else start
    if start == len(inside):
        return None
    variant = inside[start]
    if s.token.type == "EQUAL":
        remedy = "leave it out: index(v) gives 0, 1, .. in the order of the text"
        return Diagnostic("E0147", f"the variant '{variant}' has no number of its own", s.span(), remedy)
    carried = _CARRIED.match(s.source.text, variant.end_pos or 0)
    if carried is None or s.token.type not in _SIGNS:
        return None
    given = [part for part in re.split(r"[()\[\]{},|;]", carried[0]) if part.strip()]
    named = [found for part in given if (found := _NAMED.match(part.strip()))]
    if not given:
        remedy = f"write `{variant}` alone"
        return Diagnostic("E0147", f"the variant '{variant}' carries nothing", s.span(), remedy)
    if len(named) < len(given):
        return None
    if len(named) == 1:
        message = f"what '{variant}' carries is a type in parentheses, without a name"
        return Diagnostic("E0147", message, s.span(), f"write `{variant}({named[0][2]})`")
    fields = ", ".join(f"{one[1] or chr(ord('a') + n % 26)}: {one[2]}" for n, one in enumerate(named))
    remedy = f"write `{variant}(Pair)` with `record Pair {{ {fields} }}`"
    message = f"a variant carries one value, and '{variant}' is given more"
    return Diagnostic("E0147", message, s.span(), remedy)
