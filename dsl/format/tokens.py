# SPDX-License-Identifier: Apache-2.0
"""Facts of each token: how far it stands from the one before, and what it starts."""

from __future__ import annotations

from dataclasses import dataclass

from lark import Token, Tree

from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.parse import parse_concrete

OPENERS = {"(": ")", "[": "]", "{": "}"}
CLAUSES = frozenset(("arm", "fields", "variant", "assignment"))  # statements that may share a line
CLOSERS = frozenset(OPENERS.values())
SIGNS = frozenset(("=", "~", "=>"))
INFIX = frozenset(("+", "-", "*", "/", "//", "%", "**", "==", "!=", "<", "<=", ">", ">=", "and", "or", "|"))

_PARENTS = frozenset(("model_file", "library_file", "instance_file", "element", "policy_block"))
_NOTCLAUSES = frozenset(("binder", "rhs"))
_OPERANDS = frozenset(
    ("NAME", "INT", "FLOAT", "STRING", "TRUE", "FALSE", "BOOL", "PROB", "INT_TYPE", "FLOAT_TYPE")
)


@dataclass(frozen=True)
class Piece:
    """A token and its place in the text's structure; other tokens are named by their index.

    ``gap``: spaces before it if it does not start a line. ``statement``: the first token of the innermost
    item, member, arm or the like that it belongs to. ``kind``: what it starts, or "". ``opener``: the
    innermost open bracket around it (a closing bracket's own), or -1. ``element``: whether it follows an
    opening bracket or a comma directly. ``nested``: how many conditions and ``then`` branches it stands in.
    ``partner``: of an ``else`` its ``then``, of a ``then`` its ``if``, or -1.
    """

    text: str
    start: int
    gap: int
    statement: int
    kind: str
    opener: int
    element: bool
    role: str
    nested: int
    partner: int

    @property
    def end(self) -> int:
        """Return the offset behind the token."""
        return self.start + len(self.text)


def annotate(source: Source) -> list[Piece]:
    """Return the text's tokens; raises ``ModelError`` where the text does not parse."""
    tree, tokens = parse_concrete(source)
    index = {token.start_pos: number for number, token in enumerate(tokens)}
    kinds, owners = _statements(tree, tokens, index)
    nested, partners = _conditionals(tokens)
    pieces: list[Piece] = []
    open_brackets: list[int] = []
    unit = False
    for number, token in enumerate(tokens):
        before = tokens[number - 1] if number else None
        unit = unit or (token == "<" and before is not None and before.type == "FLOAT_TYPE")
        gap = 0 if unit else _gap(before, token, tokens[number - 2] if number > 1 else None)
        unit = unit and token != ">"
        kind = kinds.get(number, "")
        if kind and before is not None and before not in ("{", ",", "|") and gap:
            gap = 2  # two statements share a line
        opener = open_brackets[-1] if open_brackets else -1
        element = before is not None and (before in OPENERS or before == ",") and opener >= 0
        assert token.start_pos is not None
        pieces.append(
            Piece(
                str(token),
                token.start_pos,
                gap,
                owners[number],
                kind,
                opener,
                element,
                _role(token, kind),
                nested[number],
                partners.get(number, -1),
            )
        )
        if token in OPENERS:
            open_brackets.append(number)
        elif token in CLOSERS:
            open_brackets.pop()
    return pieces


def _conditionals(tokens: list[Token]) -> tuple[list[int], dict[int, int]]:
    """Return how deeply each token is nested in conditionals, and the partners of ``then`` and ``else``.

    What follows an ``else`` is nested no deeper than its ``if``, so that a chain of cases is one level.
    """
    depths: list[int] = []
    partners: dict[int, int] = {}
    waiting: list[list[int]] = [[]]  # for each open bracket, every `if` or `then` that still goes on
    for number, token in enumerate(tokens):
        if token in CLOSERS:
            waiting.pop()
        ifs = waiting[-1]
        if token == "then":
            partners[number], ifs[-1] = ifs[-1], number
        elif token == "else" and ifs and tokens[ifs[-1]] == "then":
            partners[number] = ifs.pop()
        depths.append(sum(map(len, waiting)) - (token == "then"))
        if token in OPENERS:
            waiting.append([])
        elif token == "if":
            ifs.append(number)
    return depths, partners


def _statements(
    tree: Tree[Token], tokens: list[Token], index: dict[int | None, int]
) -> tuple[dict[int, str], list[int]]:
    """Return what each token starts, where it starts anything, and each token's innermost statement."""
    kinds: dict[int, str] = {0: "file"}
    owners = [0] * len(tokens)
    ends = {token.end_pos: number for number, token in enumerate(tokens)}
    pending = [tree]
    while pending:  # an inner statement comes later and wins
        parent = pending.pop()
        for child in parent.children:
            if not isinstance(child, Tree) or child.meta.empty:
                continue
            pending.append(child)
            own = parent.data in _PARENTS and child.data not in _NOTCLAUSES
            chosen = parent.data == "policy_block" and child.data == "rhs"
            if own or chosen or child.data in CLAUSES:
                first, last = index[child.meta.start_pos] - chosen, ends[child.meta.end_pos]
                kinds[first] = "choose" if chosen else str(child.data)
                owners[first : last + 1] = [first] * (last + 1 - first)
    return kinds, owners


def _role(token: Token, kind: str) -> str:
    """Return the class of tokens that this one may be aligned with."""
    if kind:
        return "statement"
    if token in SIGNS:
        return "sign"
    if _is_operand(token) or token in ("(", "["):
        return "operand"
    return str(token)


def _is_operand(token: Token) -> bool:
    return token.type in _OPERANDS


def _ends_operand(token: Token | None) -> bool:
    return token is not None and (_is_operand(token) or token in (")", "]", "}", "'"))


def _gap(before: Token | None, token: Token, second: Token | None) -> int:
    """Return how many spaces stand between two tokens of a line; ``second`` comes before ``before``."""
    if before is None:
        return 0
    if token in (",", ":", "'", ")", "]", ".", "^") or before in ("(", "[", ".", "^"):
        return 0
    if before == "{" and token == "}":
        return 0
    if before == "-" and not _ends_operand(second):
        return 0  # a sign, not a difference
    if token == "(":
        return 0 if before.type == "NAME" else 1
    if token == "[":
        return 0 if _ends_operand(before) and before != "}" or before == ">" else 1
    return 1
