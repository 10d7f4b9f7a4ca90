# SPDX-License-Identifier: Apache-2.0
"""The one layout of a model's text: spaces, indentation and line ends. Tokens and comments never change."""

from __future__ import annotations

from hypgen.dsl.format.breaks import break_long_lines
from hypgen.dsl.format.layout import place
from hypgen.dsl.format.lines import read_lines, write_lines
from hypgen.dsl.format.tokens import annotate
from hypgen.dsl.messages.source import Source

_ROUNDS = 100


def format_source(source: Source) -> str:
    """Return the text in its canonical layout; raises ``ModelError`` where it does not parse.

    Formatting the result gives the result.
    """
    pieces = annotate(source)
    lines = read_lines(source.text, pieces)
    text = ""
    for _ in range(
        _ROUNDS
    ):  # a line that is broken, or a column that moves, changes what is aligned with what
        lines = break_long_lines(place(lines, pieces), pieces)
        before, text = text, write_lines(lines, pieces)
        if text == before:
            break
    if _significant(Source(source.name, text)) != _significant(source):
        raise AssertionError("formatting would change the text's tokens")
    return text


def _significant(source: Source) -> list[str]:
    """Return what formatting must not touch: the tokens and, where they stand among them, the comments."""
    pieces = annotate(source)
    result = []
    for line in read_lines(source.text, pieces):
        result += [pieces[number].text for number in line.tokens]
        result += [line.comment] if line.comment else []
    return result
