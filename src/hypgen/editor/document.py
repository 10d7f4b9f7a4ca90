# SPDX-License-Identifier: Apache-2.0
"""A text in an editor: what the front end says of it, and of its last form without mistakes."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

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
_OWNERS = (ast.Element, ast.EnumDecl, ast.RecordDecl, ast.Function, ast.Policy)


@dataclass(frozen=True)
class Declared:
    """A declaration: what it is, its name, its node, and the item that holds it, or None."""

    word: str
    name: str
    node: ast.Node
    holder: str | None


class Stopped(Exception):
    """A check was given up, as its text is no longer what the editor has."""


@dataclass(frozen=True)
class Checked:
    """What the front end says of a text; ``tree`` and ``loaded`` are None where mistakes hide them."""

    text: str
    found: tuple[Diagnostic, ...]
    tree: ast.File | None = None
    loaded: Loaded | LoadedLibrary | None = None
    sources: Mapping[str, Source] = field(default_factory=dict)


# The front end raises Python's limit of recursion for the while, which all threads share.
_ONE_AT_A_TIME = threading.Lock()


def _never() -> bool:
    return False


@dataclass
class Document:
    """One open text. ``tree`` is of the last text that parses, ``loaded`` of the last without mistakes.

    ``edited`` has the contents of all open texts, by real path: they stand for what is on disk.
    """

    path: str
    text: str = ""
    edited: Mapping[str, bytes] = field(default_factory=dict)
    tree: ast.File | None = None
    tree_text: str = ""
    loaded: Loaded | LoadedLibrary | None = None
    loaded_text: str = ""
    checked: Checked = field(default_factory=lambda: Checked("", ()))

    def check(self) -> tuple[Diagnostic, ...]:
        """Return every mistake and warning of the text, and keep what is good of it."""
        return self.take(self.examine(self.text))

    def take(self, checked: Checked) -> tuple[Diagnostic, ...]:
        """Keep what is good of a text that has been examined, and return what is wrong with it."""
        self.checked = checked
        if checked.tree is not None:
            self.tree, self.tree_text = checked.tree, checked.text
        if checked.loaded is not None:
            self.loaded, self.loaded_text = checked.loaded, checked.text
        return checked.found

    def current(self) -> Checked:
        """Return what is said of the present text, which may have been examined already."""
        return self.checked if self.checked.text == self.text else self.examine(self.text)

    def diagnostics_of(self, text: str) -> tuple[Diagnostic, ...]:
        """Return what is said of another text at the same path; nothing is kept."""
        return self.examine(text).found

    def examine(self, text: str, stopped: Callable[[], bool] = _never) -> Checked:
        """Return what is said of a text at this path; raises ``Stopped`` between passes once told to."""
        source = Source(self.path, text.replace("\r\n", "\n").replace("\r", "\n"))
        if not source.text.strip():
            return Checked(source.text, (e00_files.empty(self.path, None),))
        tree: ast.File | None = None

        def watch(name: str, given: object) -> None:
            nonlocal tree
            if stopped():
                raise Stopped
            if isinstance(given, ast.File) and name == "parse" and given.span.file == self.path:
                tree = given

        with _ONE_AT_A_TIME:
            watch("start", None)
            if next((t.text for t in lexemes(text) if t.kind != "COMMENT"), "") == "instance":
                try:
                    tree = parse(source)
                except ModelError as error:
                    return Checked(source.text, error.diagnostics)
            try:
                loaded = load_any(self.path, given=source, edited=self.edited, watch=watch)
            except ModelError as error:
                return Checked(source.text, error.diagnostics, tree, None, error.sources)
        warnings = loaded.warnings if isinstance(loaded, Loaded) else ()
        return Checked(source.text, warnings, tree, loaded, loaded.sources)

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
        return self.item_at(line, (ast.Element,))

    def item_at(self, line: int, kinds: tuple[type[Any], ...] = _OWNERS) -> str | None:
        """Return the item with names of its own that a line, counted from 1, stands in."""
        for item in getattr(self.tree, "items", ()):
            if isinstance(item, kinds) and item.span.line <= line <= item.span.end_line:
                return str(item.name)
        return None


def citation(checked: Checked, path: str, file: str) -> tuple[int, int] | None:
    """Return the offsets at which the text at ``path`` names a file, itself or by what it imports.

    Tokens tell, as either text may not parse.
    """
    own, seen = Source(path, checked.text), {os.path.realpath(path)}
    sources = {os.path.realpath(name): source for name, source in checked.sources.items()}

    def leads(to: str) -> bool:
        if to == os.path.realpath(file):
            return True
        if to in seen or to not in sources:
            return False
        seen.add(to)
        return any(leads(inner) for inner, _ in _cited(sources[to]))

    return next(((t.start, t.end) for to, t in _cited(own) if leads(to)), None)


def _cited(source: Source) -> Iterator[tuple[str, Lexeme]]:
    """Yield the real paths of the files that a text names, and the tokens that name them."""
    tokens = (t for t in lexemes(source.text) if t.kind != "COMMENT")
    for word, token in pairwise(tokens):
        if word.text in ("import", "of") and token.kind == "STRING":
            path = os.path.join(os.path.dirname(source.name), token.text[1:-1])
            yield os.path.realpath(path), token


def _declared(node: ast.Node, holder: str | None) -> Iterator[Declared]:
    word = _WORDS.get(type(node))
    name = getattr(node, "name", None)
    if word is not None and name is not None:
        yield Declared(word, name, node, holder)
    inner = name if isinstance(node, _OWNERS) else holder
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
