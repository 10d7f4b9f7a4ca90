# SPDX-License-Identifier: Apache-2.0
"""Colours of models; the words come from the grammar, so that none is missed."""

import re
from pathlib import Path
from typing import ClassVar

from pygments.lexer import RegexLexer, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text

_GRAMMAR = Path(__file__).parents[2] / "dsl" / "syntax" / "pomdp.lark"
TYPES = frozenset(("bool", "float", "int", "prob"))
_VALUES = frozenset(("true", "false"))


def reserved_words() -> list[str]:
    """Return the words of the grammar, which no name may be, in order of the alphabet."""
    text = re.sub(r"^\s*//.*$", "", _GRAMMAR.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return sorted(set(re.findall(r'"([a-z]+)"', text)))


class ModelLexer(RegexLexer):
    """The Pygments lexer of ``.pomdp`` models."""

    name = "hypgen"
    aliases: ClassVar[list[str]] = ["pomdp", "pomdp-part", "pomdp-instance", "pomdp-library", "pomdp-import"]
    tokens: ClassVar[dict[str, list[object]]] = {
        "root": [
            (r"\s+", Text),
            (r"#[^\n]*", Comment.Single),
            (r'"[^"\n]*"', String),
            (r"\d+\.\d+([eE][+-]?\d+)?|\d+[eE][+-]?\d+", Number.Float),
            (r"\d+", Number.Integer),
            (words(sorted(TYPES), prefix=r"\b", suffix=r"\b"), Keyword.Type),
            (words(sorted(_VALUES), prefix=r"\b", suffix=r"\b"), Keyword.Constant),
            (words(reserved_words(), prefix=r"\b", suffix=r"\b"), Keyword),
            (r"[A-Za-z_][A-Za-z0-9_]*(?=\()", Name.Function),
            (r"[A-Za-z_][A-Za-z0-9_]*", Name),
            (r"[=~<>!+*/%^|'-]+|\.\.", Operator),
            (r"[][(){}.,:]", Punctuation),
        ]
    }
