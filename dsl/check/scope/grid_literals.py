# SPDX-License-Identifier: Apache-2.0
"""Grid literals: strings of glyphs, one character an entry, that write arrays of an enum's variants."""

from __future__ import annotations

from functools import partial

from hypgen.dsl.messages import e03_values
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Enum, Type, size_of


def is_grid(node: ast.Expr) -> bool:
    """Return whether ``node`` is a string, or a list whose first entry is a grid."""
    while isinstance(node, ast.ArrayLiteral) and node.items:
        node = node.items[0]
    return isinstance(node, ast.Literal) and isinstance(node.value, str)


def has_glyphs(element: Type) -> bool:
    """Return whether strings write values of ``element`` by glyphs; of other types they list words."""
    return isinstance(element, Enum) and bool(element.glyphs)


def row(node: ast.Literal, element: Type, index: Type, name: str) -> tuple[int, ...]:
    """Return the codes that a string of glyphs writes, one for each value of ``index``."""
    text = node.value
    assert isinstance(text, str) and isinstance(element, Enum)
    if len(text) != size_of(index):
        raise Mistake(e03_values.wrong_number_of_glyphs(name, index, len(text), node.span))
    return tuple(gather([partial(_code, g, element, _place(node.span, i)) for i, g in enumerate(text)]))


def _place(string: Span, offset: int) -> Span:
    """Return where the character at ``offset`` of a string stands."""
    column = string.column + 1 + offset
    return Span(string.file, string.line, column, string.line, column + 1)


def _code(glyph: str, element: Enum, span: Span) -> int:
    if glyph in element.glyphs:
        return element.glyphs[glyph]
    raise Mistake(e03_values.unknown_glyph(element, glyph, span))


def check_glyphs(nodes: tuple[ast.VariantDecl, ...]) -> None:
    """Raise unless each glyph of an enum is one character, of one variant without an argument."""
    first: dict[str, ast.VariantDecl] = {}
    gather([partial(_check_glyph, n, first) for n in nodes])


def _check_glyph(node: ast.VariantDecl, first: dict[str, ast.VariantDecl]) -> None:
    if node.glyph is None:
        return
    if len(node.glyph) != 1:
        raise Mistake(e03_values.long_glyph(node.name, len(node.glyph), node.span))
    if node.argument is not None:
        raise Mistake(e03_values.glyph_with_argument(node.name, node.span))
    other = first.setdefault(node.glyph, node)
    if other is not node:
        raise Mistake(e03_values.same_glyph(node.name, other.name, node.span, other.span))
