"""Grid literals: strings of glyphs, one character an entry, that write arrays of an enum's variants."""

from __future__ import annotations

from functools import partial

from hypgen.dsl.messages.report import gather, mistake
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
        raise mistake(
            "E0309",
            f"'{name}' takes {size_of(index)} glyphs here, but the string has {len(text)}",
            node.span,
            f"give one for each value of {index}",
        )
    return tuple(gather([partial(_code, g, element, _place(node.span, i)) for i, g in enumerate(text)]))


def _place(string: Span, offset: int) -> Span:
    """Return where the character at ``offset`` of a string stands."""
    column = string.column + 1 + offset
    return Span(string.file, string.line, column, string.line, column + 1)


def _code(glyph: str, element: Enum, span: Span) -> int:
    if glyph in element.glyphs:
        return element.glyphs[glyph]
    known = ", ".join(f"'{g}' {v.name}" for v in element.variants if (g := v.glyph) is not None)
    other = next((g for g in element.glyphs if g.lower() == glyph.lower()), None)
    remedy = f"did you mean '{other}'?" if other is not None else f"its glyphs are {known}"
    raise mistake("E0311", f"enum '{element}' has no glyph '{glyph}'", span, remedy)


def check_glyphs(nodes: tuple[ast.VariantDecl, ...]) -> None:
    """Raise unless each glyph of an enum is one character, of one variant without an argument."""
    first: dict[str, ast.VariantDecl] = {}
    gather([partial(_check_glyph, n, first) for n in nodes])


def _check_glyph(node: ast.VariantDecl, first: dict[str, ast.VariantDecl]) -> None:
    if node.glyph is None:
        return
    if len(node.glyph) != 1:
        raise mistake(
            "E0312",
            f"the glyph of '{node.name}' has {len(node.glyph)} characters",
            node.span,
            "a glyph is one character",
        )
    if node.argument is not None:
        raise mistake(
            "E0312",
            f"'{node.name}' has an argument, which no glyph tells",
            node.span,
            "remove the glyph, or make a variant of each argument",
        )
    other = first.setdefault(node.glyph, node)
    if other is not node:
        raise mistake(
            "E0312",
            f"'{node.name}' and '{other.name}' have the same glyph",
            node.span,
            "give each variant a glyph of its own",
            [(other.span, f"'{other.name}' has it already")],
        )
