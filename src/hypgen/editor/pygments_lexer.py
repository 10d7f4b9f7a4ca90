# SPDX-License-Identifier: Apache-2.0
"""Colours of Pygments, which Sphinx, MkDocs, LaTeX's minted and notebooks use."""

from __future__ import annotations

from collections.abc import Iterator

from pygments.lexer import Lexer
from pygments.token import Token, _TokenType

from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.messages.source import Source
from hypgen.editor.words import lexemes

_TYPES = {
    "declarations": Token.Keyword.Declaration,
    "control": Token.Keyword,
    "operators": Token.Operator.Word,
    "types": Token.Keyword.Type,
    "constants": Token.Keyword.Constant,
    "functions": Token.Name.Builtin,
    "values": Token.Name.Builtin,
    "symbols": Token.Operator,
    "COMMENT": Token.Comment.Single,
    "STRING": Token.String,
    "FLOAT": Token.Number.Float,
    "INT": Token.Number.Integer,
    "NAME": Token.Name,
    "OTHER": Token.Error,
}


class ModelLexer(Lexer):
    """The lexer of `.pomdp` files of hypgen."""

    name = "hypgen"
    aliases = ["pomdp", "hypgen"]
    filenames = ["*.pomdp"]

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, _TokenType, str]]:
        """Yield each token's offset, type and text; together they are the text."""
        end = 0
        for lexeme in lexemes(text):
            if lexeme.start > end:
                yield end, Token.Text.Whitespace, text[end : lexeme.start]
            yield lexeme.start, _TYPES[lexeme.kind], lexeme.text
            end = lexeme.end
        if end < len(text):
            yield end, Token.Text.Whitespace, text[end:]

    @staticmethod
    def analyse_text(text: str) -> float:
        """Return how likely a text is ours: not, where it is in Cassandra's format."""
        return 0.0 if recognise(Source("", text)) else 0.1
