# SPDX-License-Identifier: Apache-2.0
"""A text in an editor: what the front end says of it, and of its last form without mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from hypgen.dsl.load import Loaded, LoadedLibrary, load_any
from hypgen.dsl.messages import e00_files
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse
from hypgen.editor.words import Lexeme, lexemes

_WORDS: dict[type[ast.Node], str] = {
    ast.Const: "const",
    ast.Param: "param",
    ast.TypeAlias: "type",
    ast.EnumDecl: "enum",
    ast.VariantDecl: "variant",
    ast.RecordDecl: "record",
    ast.FieldDecl: "field",
    ast.Function: "fn",
    ast.Action: "action",
    ast.Variable: "variable",
    ast.Let: "let",
    ast.LetIn: "let",
    ast.Observe: "observe",
    ast.Reward: "reward",
    ast.Element: "element",
    ast.Memory: "memory",
    ast.Policy: "policy",
    ast.Bound: "bound",
    ast.Binder: "binder",
}


@dataclass(frozen=True)
class Declared:
    """A declaration: what it is, its name, its node, and the item that holds it, or None."""

    word: str
    name: str
    node: ast.Node
    holder: str | None


@dataclass
class Document:
    """One open text. ``tree`` is of the last text that parses, ``loaded`` of the last without mistakes."""

    path: str
    text: str = ""
    tree: ast.File | None = None
    tree_text: str = ""
    loaded: Loaded | LoadedLibrary | None = None
    loaded_text: str = ""
    found: tuple[Diagnostic, ...] = field(default=())

    def check(self) -> tuple[Diagnostic, ...]:
        """Return every mistake and warning of the text, and keep what is good of it."""
        source = Source(self.path, self.text.replace("\r\n", "\n").replace("\r", "\n"))
        try:
            self.tree, self.tree_text = parse(source), source.text
        except ModelError as error:
            self.found = error.diagnostics
            return self.found
        self.found = self._load(source)
        return self.found

    def diagnostics_of(self, text: str) -> tuple[Diagnostic, ...]:
        """Return what is said of another text at the same path; nothing is kept."""
        other = Document(self.path, text)
        return other.check()

    def _load(self, source: Source) -> tuple[Diagnostic, ...]:
        if not source.text.strip():
            return (e00_files.empty(self.path, None),)
        try:
            self.loaded = load_any(self.path, given=source)
        except ModelError as error:
            return error.diagnostics
        self.loaded_text = source.text
        return self.loaded.warnings if isinstance(self.loaded, Loaded) else ()

    def lexeme_at(self, offset: int) -> Lexeme | None:
        """Return the token at an offset, or that which ends there."""
        near = [t for t in lexemes(self.text) if t.start <= offset <= t.end]
        return max(near, key=lambda t: (t.kind not in ("symbols", "COMMENT"), t.start), default=None)

    def declared(self) -> list[Declared]:
        """Return the declarations of the last text that parses, those of its libraries behind its own."""
        roots: list[ast.Node] = [] if self.tree is None else [self.tree]
        if self.loaded is not None:
            roots += [i for i in self.loaded.ast.items if i.span.file != self.path]
        return [d for root in roots for d in _declared(root, None)]

    def text_of(self, file: str) -> str:
        """Return the text that the places of declarations point into."""
        if file == self.path:
            return self.tree_text
        return "" if self.loaded is None else self.loaded.sources[file].text

    def name_span(self, declared: Declared) -> Span:
        """Return where a declaration has its name."""
        span = declared.node.span
        lines = self.text_of(span.file).split("\n")
        for number in range(span.line, span.end_line + 1):
            start = span.column - 1 if number == span.line else 0
            for lexeme in lexemes(lines[number - 1][start:]):
                if lexeme.text == declared.name:
                    at = start + lexeme.start + 1
                    return Span(span.file, number, at, number, at + len(declared.name))
        return span

    def element_at(self, line: int) -> str | None:
        """Return the element that a line, counted from 1, stands in."""
        items = getattr(self.tree, "items", ())
        inside = (i for i in items if isinstance(i, ast.Element) and i.span.line <= line <= i.span.end_line)
        return next((i.name for i in inside), None)


def _declared(node: ast.Node, holder: str | None) -> Iterator[Declared]:
    word = _WORDS.get(type(node))
    name = getattr(node, "name", None)
    if word is not None and name is not None:
        yield Declared(word, name, node, holder)
    own = isinstance(node, (ast.Element, ast.EnumDecl, ast.RecordDecl, ast.Function, ast.Policy))
    inner = name if own else holder
    children = list(walk_once(node))
    for child in children:
        yield from _declared(child, inner)


def walk_once(node: ast.Node) -> Iterator[ast.Node]:
    """Yield the nodes directly inside a node."""
    for name in node.__dataclass_fields__:
        pending = [getattr(node, name)]
        while pending:
            value = pending.pop()
            if isinstance(value, ast.Node):
                yield value
            elif isinstance(value, tuple):
                pending += reversed(value)
