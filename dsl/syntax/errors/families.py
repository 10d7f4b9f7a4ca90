# SPDX-License-Identifier: Apache-2.0
"""Syntax mistakes in what an element is indexed by: `element lamp[Row, Col] {`, `element lamp[3] {`."""

from __future__ import annotations

import re

from hypgen.dsl.messages import e01_syntax
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import Situation

_ONE = re.compile(
    r"\s*[\[(]?\s*(?:for\s+)?(?:(\w+)\s*(?::|\bin\b)\s*)?([^\[\](){},:]+?)\s*[\])]?\s*(?=[:{]|$)"
)
_PAIR = re.compile(r"\s*\[([^\[\]{}\n]*)\](?:\s*\[([^\[\]{}\n]*)\])?")


def family_index(s: Situation) -> Diagnostic | None:
    """Know `lamp[A, B]`, `lamp[a in A][b in B]`, `lamp[a: A]`, `lamp[3]`, `lamp(a in A)`.

    Know `lamp for a in A`, too.
    """
    at = next((n for n in range(len(s.before) - 1, -1, -1) if s.before[n].type == "ELEMENT"), None)
    if at is None or at + 1 >= len(s.before) or s.before[at + 1].type != "NAME":
        return None
    if any(t.type == "LBRACE" for t in s.before[at:]) or s.token.line != s.before[at].line:
        return None
    if s.follows("ELEMENT", "NAME", "LSQB", "NAME") and s.token.type in ("NAME", "RSQB"):
        return None  # `lamp[Row]`, which `_foreign_binder` knows
    name = s.before[at + 1]
    header = s.source.text[name.end_pos :].split("\n")[0]
    pair = _PAIR.match(header)
    if pair is not None and s.token.type in ("COMMA", "LSQB"):
        given = pair[1].split(",") if pair[2] is None else [pair[1], pair[2]]
        named = [re.fullmatch(r"\s*(?:(\w+)\s+in\s+)?(.+?)\s*", part) for part in given]
        if len(named) > 1 and all(named):
            indexes = [(one[1] or chr(ord("a") + n % 26), one[2]) for n, one in enumerate(named) if one]
            return e01_syntax.several_indexes(str(name), indexes, s.span())
    one = _ONE.match(header)
    if one is None or not re.match(r"\s*(\[|\(|for\b)", header):
        return None
    over = f"0 .. {int(one[2]) - 1}" if one[2].isdigit() and int(one[2]) > 0 else one[2]
    remedy = f"write `element {name}[{one[1] or 'i'} in {over}]`"
    return Diagnostic("E0145", "what a family runs over is written `name in Type`", s.span(), remedy)
