"""Syntax errors in the author's words: what stood there, what was expected, and how to write it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from lark import Lark, Token, UnexpectedCharacters, UnexpectedInput

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Source, Span

UNKNOWN = "?"  # the token type of a character that starts no token
END = "$END"
CLOSERS = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
SIGNS = {"LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]", "LBRACE": "{", "RBRACE": "}"}

_FORMS = {
    "MODEL": "model Name",
    "INSTANCE": 'instance name of "model.pomdp" { name = value }',
    "LIBRARY": "library name",
    "IMPORT": 'import "library.pomdp"',
    "CONST": "const name: type = value",
    "PARAM": "param name: type = default",
    "TYPE": "type Name = 0 .. 3",
    "ENUM": "enum Name { first, second, third(Type) }",
    "RECORD": "record Name { first: type  second: type }",
    "FN": "fn name(x: type): type = expression",
    "ACTION": "action name: Type",
    "ELEMENT": "element name { declarations }` or `element name[i in Type] { declarations }",
    "VISIBLE": "visible name: type",
    "HIDDEN": "hidden name: type",
    "INIT": "init name = value` or `init name ~ distribution",
    "OBSERVE": "observe name: type ~ distribution",
    "REWARD": "reward name = expression",
    "INVARIANT": "invariant condition",
    "MEMORY": "memory name: type = first",
    "CHOOSE": "choose = expression` or `choose ~ distribution",
    "POLICY": "policy default = expression",
    "BOUND": "bound upper = expression",
    "DISCOUNT": "discount 0.95",
    "HORIZON": "horizon 100",
    "TERMINAL": "terminal when condition",
    "LEGAL": "legal when condition",
    "SUCCESS": "success when condition",
    "MATCH": "match value { first => expression  else => expression }",
    "IF": "if condition then expression else expression",
}
_WORDS = {
    "NAME": "a name",
    "STRING": "a text in double quotes",
    "INT": "an integer",
    "EQUAL": "'='",
    "TILDE": "'~'",
    "COLON": "':'",
    "COMMA": "','",
    "DOT": "'.'",
    "QUOTE": "'''",
    "_ARROW": "'=>'",
    "_DOTDOT": "'..'",
    "VBAR": "'|'",
    END: "the end of the file",
    **{name: f"'{sign}'" for name, sign in SIGNS.items()},
}


@dataclass(frozen=True)
class Situation:
    """Where the parser gave up: the offending token, the tokens before it, and what it would have taken."""

    source: Source
    token: Token
    before: tuple[Token, ...]
    accepts: frozenset[str]

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


def explain(error: UnexpectedInput, source: Source, lark: Lark) -> Diagnostic:
    """Return the diagnostic for a syntax error: a known mistake, or what was expected instead."""
    from hypgen.dsl.syntax.errors.rules import MISTAKES

    situation = _situation(error, source, lark)
    for mistake in MISTAKES:
        diagnostic = mistake(situation)
        if diagnostic is not None:
            return diagnostic
    return _unexpected(situation)


def _situation(error: UnexpectedInput, source: Source, lark: Lark) -> Situation:
    failure: Any = error  # lark leaves the attributes of its exceptions untyped
    if isinstance(error, UnexpectedCharacters):
        position, text = failure.pos_in_stream, source.text[failure.pos_in_stream]
        end = (error.line, error.column + 1, position + 1)
        token = Token(UNKNOWN, text, position, error.line, error.column, *end)
    else:
        token = failure.token
    text_before = source.text if token.type == END else source.text[: token.start_pos]
    before = tuple(lark.lex(text_before))
    accepts = frozenset(failure.interactive_parser.accepts())
    return Situation(source, token, before, accepts)


def shown(token: Token) -> str:
    """Return how a message names a token."""
    if token.type == END:
        return "the end of the file"
    if token.type in ("INT", "FLOAT"):
        return f"the number {token}"
    if token.type == "STRING":
        return f"the text {token}"
    return f"the name '{token}'" if token.type == "NAME" else f"'{token}'"


def _unexpected(situation: Situation) -> Diagnostic:
    expected = _expected(situation)
    if situation.token.type == END:
        message = f"the file ends too early: expected {expected}"
    elif situation.token.type == UNKNOWN:
        message = f"'{situation.token}' has no meaning here: expected {expected}"
    else:
        message = f"expected {expected}; found {shown(situation.token)}"
    code = "E0102" if situation.token.type == UNKNOWN else "E0101"
    return Diagnostic(code, message, situation.span(), _remedy(situation))


def _expected(situation: Situation) -> str:
    accepts = set(situation.accepts)
    words = []
    if situation.expects_expression and "IF" in accepts:
        words.append("an expression")
        accepts = set()
    elif situation.expects_expression:
        words.append("an operand")
        accepts = set()
    elif {"BOOL", "PROB"} <= accepts:
        words.append("a type")
        accepts = set()
    if {"PLUS", "STAR"} <= accepts or _after_operand(situation):
        words.append("an operator")
        accepts -= {"DOT", "QUOTE", "LSQB", "_DOTDOT"}
    if situation.expects_item:
        words.append("a declaration")
        accepts -= {END}
    elif situation.expects_member:
        words.append("a declaration of the element")
        accepts -= {"NAME"}
    elif {"NAME", "ELSE", "TRUE"} <= accepts:
        words.append("another arm")
        accepts -= {"NAME", "INT", "ELSE"}
    keywords = ("THEN", "ELSE", "IN", "WHERE", "WHEN", "OF", "CHOOSE", "MODEL", "INSTANCE")
    words += sorted(f"'{k.lower()}'" for k in keywords if k in accepts)
    words += sorted(word for name, word in _WORDS.items() if name in accepts)
    words = words or ["'>'"]  # the end of a unit, whose other operators are left to the form
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


def _after_operand(situation: Situation) -> bool:
    """Return whether an expression may have been meant to go on.

    What it accepts does not say so once a name, which may start an update, has ended the expression.
    """
    previous = situation.previous()
    return (
        (situation.expects_item or situation.expects_member)
        and previous is not None
        and previous.type in ("NAME", "INT", "FLOAT", "RPAR", "RSQB", "QUOTE")
        and any(t.type in ("EQUAL", "TILDE", "WHEN", "DISCOUNT", "HORIZON") for t in situation.before)
    )


def _remedy(situation: Situation) -> str:
    """Show the form of what the author was most likely writing."""
    started = next((t for t in reversed(situation.before) if t.type in _FORMS), None)
    if started is None:
        return "see the examples for how a model is written"
    return f"the form is `{_FORMS[started.type]}`"
