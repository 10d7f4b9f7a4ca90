# SPDX-License-Identifier: Apache-2.0
"""Comments of other languages: ``// text``, ``/* text */``, ``-- text`` and ``% text``."""

from __future__ import annotations

import re
from collections.abc import Iterator

from lark import Token

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import Situation

# Words side by side, or a mark at the end: a sentence and no expression.
_PROSE = re.compile(r"[A-Za-z]\w*[ \t]+\w|\w[ \t]+[A-Za-z]|[.!?:;][ \t]*$")
_NOTHING = re.compile(r"(?:\s+|#[^\n]*)*")


def foreign_comment(s: Situation) -> Diagnostic | None:
    """Know a comment, also where its sign was taken for an operator that divides or subtracts."""
    sign = s.rest[:2]
    if sign in ("//", "/*") and "FLOORDIV" not in s.accepts:
        return _told(s, s.token, sign)
    for first, sign in _signs(s):
        start = first.start_pos or 0
        line_start = s.source.text.rfind("\n", 0, start) + 1
        tail = s.source.text[start + len(sign) :].split("\n")[0]
        alone = sign == "//" and not s.source.text[line_start:start].strip()
        if sign in ("%", "--") and s.token.type in ("THEN", "ELSE"):
            continue  # an `if` is lacking
        if sign == "/*" or alone or (_PROSE.search(tail) and _reads_further(s, start, len(sign + tail))):
            return _told(s, first, sign)
    return None


def _signs(s: Situation) -> Iterator[tuple[Token, str]]:
    """Yield what may start a comment in the line of the mistake or of the token before it."""
    words = (*s.before, s.token)
    lines = {t.line for t in words[-2:]}
    for token, after in zip(words, (*words[1:], None), strict=True):
        if token.line not in lines:
            continue
        if token.type == "FLOORDIV":
            yield token, "//"
        elif token.type == "PERCENT":
            yield token, "%"
        elif after is not None and token.end_pos == after.start_pos:
            pair = str(token) + str(after)[:1]
            if pair in ("/*", "--"):
                yield token, pair


def _reads_further(s: Situation, start: int, length: int) -> bool:
    """Return whether the parser, without these characters, takes what follows them and the mistake."""
    text = s.source.text[:start] + " " * length + s.source.text[start + length :]
    follows = _NOTHING.match(text, start)
    assert follows is not None
    reached = s.reach(text)
    return reached == len(text) or reached > max(s.token.start_pos or 0, follows.end())


def _told(s: Situation, first: Token, sign: str) -> Diagnostic:
    message = f"'{sign}' does not start a comment"
    return Diagnostic("E0121", message, s.span(first, length=len(sign)), "comments start with `#`")
