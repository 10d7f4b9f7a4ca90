# SPDX-License-Identifier: Apache-2.0
"""Syntax errors in the author's words: what stood there, what was expected, and how to write it."""

from __future__ import annotations

from functools import partial
from typing import Any

from lark import Lark, Token, UnexpectedCharacters, UnexpectedInput

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.errors.rules import MISTAKES
from hypgen.dsl.syntax.errors.situation import END, SIGNS, UNKNOWN, Situation, shown

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
    "LET": "let name: type = value` or `let name: type ~ distribution",
    "OBSERVE": "observe name: type ~ distribution",
    "REWARD": "reward name = expression",
    "INVARIANT": "invariant condition",
    "MEMORY": "memory name: type = first",
    "CHOOSE": "choose = expression` or `choose ~ distribution",
    "POLICY": "policy default = expression",
    "BOUND": "bound upper = expression",
    "DRAW": "draw name[i in Type where condition] = marker { x = value, y = value, colour = blue }",
    "DISCOUNT": "discount 0.95",
    "HORIZON": "horizon 100",
    "TERMINAL": "terminal when condition",
    "LEGAL": "legal when condition",
    "SUCCESS": "success when condition",
    "MATCH": "match value { first => expression  else => expression }",
    "WITH": "value with { field = new }",
    "IF": "if condition then expression else expression",
}
_UPDATE = "name' = expression` or `name' ~ distribution"
_UNFINISHED = ("IF", "MATCH", "WITH")
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


def explain(error: UnexpectedInput, source: Source, lark: Lark, start: str) -> Diagnostic:
    """Return the diagnostic for a syntax error: a known mistake, or what was expected instead.

    ``start`` is the rule of the grammar that the text was to be.
    """
    situation = _situation(error, source, lark, start)
    for mistake in MISTAKES:
        diagnostic = mistake(situation)
        if diagnostic is not None:
            return diagnostic
    return _unexpected(situation)


def _situation(error: UnexpectedInput, source: Source, lark: Lark, start: str) -> Situation:
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
    return Situation(source, token, before, accepts, partial(_reach, lark, start))


def _reach(lark: Lark, start: str, text: str) -> int:
    """Return how many characters of a text the parser takes."""
    try:
        lark.parse(text, start=start)
    except UnexpectedInput as error:
        at = error.pos_in_stream
        ended = getattr(getattr(error, "token", None), "type", None) == END
        return len(text) if at is None or ended else at
    return len(text)


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
    """Show the form of what the author was most likely writing: of an expression while it is unfinished."""
    if situation.accepts == {"QUOTE"}:
        return f"the form is `{_UPDATE}`"
    opened = {id(token) for token in situation.open}
    words = situation.before
    for n in range(len(words) - 1, -1, -1):
        if words[n].type in ("EQUAL", "TILDE") and n > 1 and words[n - 1].type == "QUOTE":
            return f"the form is `{_UPDATE}`"
        if words[n].type in _FORMS and (words[n].type not in _UNFINISHED or _is_open(n, words, opened)):
            return f"the form is `{_FORMS[words[n].type]}`"
    return "see the examples for how a model is written"


def _is_open(at: int, words: tuple[Token, ...], opened: set[int]) -> bool:
    """Return whether the `if`, `match` or `with` at a place has not ended."""
    if words[at].type == "IF":
        then = next((t for t in words[at:] if t.type == "THEN"), None)
        return id(words[at]) in opened or (then is not None and id(then) in opened)
    brace = next((t for t in words[at:] if t.type == "LBRACE"), None)
    return brace is None or id(brace) in opened
