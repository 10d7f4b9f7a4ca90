# SPDX-License-Identifier: Apache-2.0
"""Text to syntax tree, by lark's LALR(1) parser."""

from __future__ import annotations

import re
from functools import cache
from typing import cast

from lark import Lark, Token, Tree, UnexpectedInput

from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.messages import e01_syntax
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.errors.describe import explain
from hypgen.dsl.syntax.parser_tables import load_parser
from hypgen.dsl.syntax.tree_builder import build

# Later passes recurse over the tree, so its depth has a limit that is far above what a person writes.
MAX_DEPTH = 200
# A token takes some 50 us and 1 kB.
MAX_TOKENS = 100_000
_TOKEN = re.compile(r'"[^"\n]*"|#[^\n]*|\w+(?:\.\w+)?|[^\s\w]')


def parse(source: Source) -> ast.File:
    """Return the syntax tree of a model, library or instance file; raises ``ModelError``."""
    _refuse_foreign(source)
    return cast(ast.File, _parse(source, "file"))


def parse_concrete(source: Source) -> tuple[Tree[Token], list[Token]]:
    """Return the parse tree of a file and its tokens without comments; raises ``ModelError``."""
    _refuse_foreign(source)
    return _parse_tree(source, "file"), list(_load_lark().lex(source.text))


def parse_expression(source: Source) -> ast.Expr:
    """Return the syntax tree of a text that is one expression; raises ``ModelError``."""
    return cast(ast.Expr, _parse(source, "expression"))


def _refuse_foreign(source: Source) -> None:
    foreign = recognise(source)
    if foreign is not None:
        raise ModelError([foreign], {source.name: source})


def _parse(source: Source, start: str) -> object:
    content, diagnostics = build(_parse_tree(source, start), source)
    if diagnostics:
        raise ModelError(sorted(diagnostics, key=_position), {source.name: source})
    return content


def _parse_tree(source: Source, start: str) -> Tree[Token]:
    _check_length(source)
    lark = _load_lark()
    try:
        tree = lark.parse(source.text, start=start)
    except UnexpectedInput as error:
        raise ModelError([explain(error, source, lark, start)], {source.name: source}) from None
    _check_depth(tree, source)
    return tree


def _check_length(source: Source) -> None:
    for number, token in enumerate(_TOKEN.finditer(source.text)):
        if number == MAX_TOKENS:
            line = source.text.count("\n", 0, token.start()) + 1
            column = token.start() - source.text.rfind("\n", 0, token.start())
            span = Span(source.name, line, column, line, column + len(token.group()))
            raise ModelError([e01_syntax.too_long(MAX_TOKENS, span)], {source.name: source})


def _position(diagnostic: Diagnostic) -> tuple[int, int]:
    span = diagnostic.span
    return (0, 0) if span is None else (span.line, span.column)


def _check_depth(tree: Tree[Token], source: Source) -> None:
    pending = [(tree, 1)]
    while pending:
        node, depth = pending.pop()
        if depth > MAX_DEPTH:
            at = node.meta
            span = Span(source.name, at.line, at.column, at.end_line, at.end_column)
            raise ModelError([e01_syntax.too_deep(MAX_DEPTH, span)], {source.name: source})
        pending.extend(
            (c, depth + 1) for c in reversed(node.children) if isinstance(c, Tree) and not c.meta.empty
        )


@cache
def _load_lark() -> Lark:
    return load_parser()
