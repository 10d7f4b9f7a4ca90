# SPDX-License-Identifier: Apache-2.0
"""What a syntax error is told from: the offending token, those before it, and what could have stood there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from lark import Token

from hypgen.dsl.messages.source import Source, Span

UNKNOWN = "?"  # the token type of a character that starts no token
END = "$END"
CLOSERS = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
SIGNS = {"LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]", "LBRACE": "{", "RBRACE": "}"}


@dataclass(frozen=True)
class Situation:
    """Where the parser gave up: the offending token, the tokens before it, and what it would have taken.

    ``reach`` says how many characters of another text the parser would take.
    """

    source: Source
    token: Token
    before: tuple[Token, ...]
    accepts: frozenset[str]
    reach: Callable[[str], int]

    @property
    def rest(self) -> str:
        """Return the text from the offending token on."""
        return self.source.text[self.token.start_pos or 0 :] if self.token.type != END else ""

    def previous(self, distance: int = 1) -> Token | None:
        """Return the token that stands ``distance`` before the offending one."""
        return self.before[-distance] if len(self.before) >= distance else None

    def follows(self, *types: str) -> bool:
        """Return whether the tokens right before the offending one have these types."""
        return tuple(t.type for t in self.before[len(self.before) - len(types) :]) == types

    @property
    def on_new_line(self) -> bool:
        """Return whether the offending token is the first of its line."""
        previous = self.previous()
        return previous is None or previous.end_line != self.token.line

    @property
    def touches_previous(self) -> bool:
        """Return whether nothing stands between the offending token and the one before."""
        previous = self.previous()
        return previous is not None and previous.end_pos == self.token.start_pos

    @property
    def expects_expression(self) -> bool:
        """Return whether an expression could start here."""
        return {"NAME", "LPAR", "MINUS", "INT", "FLOAT"} <= self.accepts

    @property
    def expects_item(self) -> bool:
        """Return whether a declaration of the model could start here."""
        return "ELEMENT" in self.accepts

    @property
    def expects_member(self) -> bool:
        """Return whether a declaration of an element could start here."""
        return "VISIBLE" in self.accepts

    @cached_property
    def open(self) -> tuple[Token, ...]:
        """Return what has been opened and not closed, outermost first: brackets, `if` and `then`."""
        stack: list[Token] = []
        for token in self.before:
            top = stack[-1].type if stack else ""
            if token.type in CLOSERS or token.type == "IF":
                stack.append(token)
            elif token.type in CLOSERS.values():
                while stack and stack[-1].type not in CLOSERS:
                    stack.pop()
                stack = stack[:-1]
            elif token.type == "THEN" and top == "IF":
                stack[-1] = token
            elif token.type == "ELSE" and top == "THEN":
                stack.pop()
        return tuple(stack)

    @property
    def open_bracket(self) -> Token | None:
        """Return the innermost open bracket."""
        return next((t for t in reversed(self.open) if t.type in CLOSERS), None)

    def span(self, token: Token | None = None, length: int | None = None) -> Span:
        """Return the span of a token (the offending one), or of ``length`` characters from its start."""
        at = self.token if token is None else token
        if at.type == END:
            last = self.previous()
            line, column = (last.end_line or 1, last.end_column or 1) if last else (1, 1)
            return Span(self.source.name, line, column, line, column + 1)
        line, column = at.line or 1, at.column or 1
        if length is not None:
            return Span(self.source.name, line, column, line, column + length)
        return Span(self.source.name, line, column, at.end_line or line, at.end_column or column + 1)


def shown(token: Token) -> str:
    """Return how a message names a token."""
    if token.type == END:
        return "the end of the file"
    if token.type in ("INT", "FLOAT"):
        return f"the number {token}"
    if token.type == "STRING":
        return f"the text {token}"
    return f"the name '{token}'" if token.type == "NAME" else f"'{token}'"
