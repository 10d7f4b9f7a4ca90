# SPDX-License-Identifier: Apache-2.0
"""Answers about a document that need no protocol: hovers, references, renames, completions, signatures."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from hypgen.dsl.load import Loaded, decode_source, read_source
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse
from hypgen.editor.document import Declared, Document
from hypgen.editor.facts import facts
from hypgen.editor.words import Lexeme, lexemes, words

SNIPPETS = {
    "element": "element ${1:name} {\n  hidden ${2:x}: ${3:Type}\n  init $2 = $4\n  $2' = $2\n}",
    "enum": "enum ${1:Name} { ${2:a}, ${3:b} }",
    "fn": "fn ${1:name}(${2:x}: ${3:Type}): ${4:Type} = $0",
    "if": "if ${1:condition} then ${2:a} else ${3:b}",
    "let": "let ${1:x} = ${2:e} in $0",
    "match": "match ${1:e} {\n  ${2:a} => $3\n  else => $0\n}",
    "observe": "observe ${1:seen}: ${2:Type} ~ $0",
    "policy": "policy default = $0",
    "record": "record ${1:Name} { ${2:x}: ${3:Type} }",
    "reward": "reward ${1:name} = $0",
    "terminal": "terminal when $0",
}
_HOVERED = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True)
class Item:
    """A completion: its label, what it is, and a snippet or ""."""

    label: str
    detail: str
    snippet: str = ""


@dataclass(frozen=True)
class Edit:
    """A text in the place of that between two offsets of a file."""

    path: str
    start: int
    end: int
    text: str


class RenameRefused(Exception):
    """A rename would change what the model means, or cannot be known not to."""


def at(document: Document, offset: int) -> list[Declared]:
    """Return the declarations that the name at an offset may stand for, the likeliest first."""
    token = document.lexeme_at(offset)
    if token is None or not _HOVERED.fullmatch(token.text):
        return []
    found = [d for d in document.declared() if d.name == token.text]
    owner = _owner(document.text, token) or document.element_at(document.text.count("\n", 0, offset) + 1)
    return sorted(found, key=lambda d: d.holder != owner)


def hover(document: Document, offset: int) -> str:
    """Return what is known of the name at an offset, of the last model without mistakes if need be."""
    token = document.lexeme_at(offset)
    if token is None:
        return ""
    found = at(document, offset)
    if isinstance(document.loaded, Loaded) and found:
        full = f"{found[0].holder}.{token.text}" if found[0].holder else token.text
        known = {f.name: f.shown for f in facts(document.loaded)}
        if full in known or token.text in known:
            return known.get(full, known.get(token.text, ""))
    if found:
        span = found[0].node.span
        line = document.text_of(span.file).split("\n")[span.line - 1]
        return line.strip() if found[0].word != "binder" else line[span.column - 1 :][:60].split(":")[0]
    return f"`{token.text}` of the language" if token.kind in ("functions", "values") else ""


def references(document: Document, offset: int) -> list[Lexeme]:
    """Return each token of the text with the name at an offset."""
    token = document.lexeme_at(offset)
    if token is None or token.kind != "NAME":
        return []
    return [t for t in lexemes(document.text) if t.kind == "NAME" and t.text == token.text]


def references_in_libraries(document: Document, offset: int) -> list[tuple[Source, Lexeme]]:
    """Return each token of the libraries with the name at an offset, where a library declares it."""
    token, loaded = document.lexeme_at(offset), document.loaded
    if token is None or loaded is None or not any(is_elsewhere(document, d) for d in at(document, offset)):
        return []
    others = [source for name, source in loaded.sources.items() if name != document.path]
    return [(s, t) for s in others for t in lexemes(s.text) if t.kind == "NAME" and t.text == token.text]


def is_elsewhere(document: Document, declared: Declared) -> bool:
    """Return whether a declaration stands in another file than the document's."""
    return declared.node.span.file != document.path


def rename(document: Document, offset: int, new: str) -> list[Edit]:
    """Return the edits that rename a name here and in instances beside; raises ``RenameRefused``.

    A name that is declared once is renamed token by token, and the result has to pass the checker.
    """
    token = document.lexeme_at(offset)
    declared = at(document, offset)
    if token is None or not declared:
        raise RenameRefused("there is no name of the model here")
    if [t.kind for t in lexemes(new)] != ["NAME"]:
        raise RenameRefused(f"'{new}' cannot be a name")
    if any(d.severity == "error" for d in document.current().found):
        raise RenameRefused("the model has mistakes: correct them first")
    if len(declared) > 1:
        raise RenameRefused(f"'{token.text}' is declared in {len(declared)} places: rename them by hand")
    if is_elsewhere(document, declared[0]) or not isinstance(document.tree, ast.ModelFile):
        raise RenameRefused(f"'{token.text}' belongs to a library, which other models may import")
    if any(t.text == new for t in lexemes(document.text)) or any(d.name == new for d in document.declared()):
        raise RenameRefused(f"'{new}' is taken")
    edits = [Edit(document.path, t.start, t.end, new) for t in references(document, offset)]
    renamed = document.text
    for edit in reversed(edits):
        renamed = renamed[: edit.start] + new + renamed[edit.end :]
    if any(d.severity == "error" for d in document.diagnostics_of(renamed)):
        raise RenameRefused(f"the model would have mistakes with '{new}'")
    if declared[0].word == "param":
        edits += _in_instances(document, token.text, new)
    return edits


def completions(document: Document, offset: int) -> list[Item]:
    """Return what may stand at an offset: members behind a dot, else names in scope and words."""
    before = document.text[:offset].rstrip("_0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
    declared = document.declared()
    if before.endswith("."):
        owner = _owner_before(before[:-1])
        return [Item(d.name, d.word) for d in declared if d.holder == owner and d.word not in _LOCAL]
    line = document.text.count("\n", 0, offset) + 1
    element = document.element_at(line)
    names = [
        Item(d.name, d.word)
        for d in declared
        if d.word != "field" and (d.holder in (None, element) or d.word == "variant")
    ]
    table = words()
    known = [Item(w, "keyword", SNIPPETS.get(w, "")) for w in sorted(table.reserved)]
    known += [Item(f, "function", f"{f}($0)") for f in table.functions]
    known += [Item(v, "value") for v in table.values]
    return list({i.label: i for i in (*known, *names)}.values())


def signature(document: Document, offset: int) -> tuple[str, list[str], int] | None:
    """Return the text of the function called around an offset, its formals, and which one stands there."""
    depth, commas, tokens = 0, 0, [t for t in lexemes(document.text) if t.end <= offset]
    for number in range(len(tokens) - 1, 0, -1):
        text = tokens[number].text
        if text in (")", "]", "}"):
            depth += 1
        elif text in ("(", "[", "{") and depth:
            depth -= 1
        elif text == "(":
            name = tokens[number - 1].text
            node = next((d.node for d in document.declared() if d.name == name and d.word in _CALLED), None)
            if node is None:
                return None
            parts = node.formals if isinstance(node, ast.Function) else getattr(node, "fields", ())
            lines = document.text_of(node.span.file).split("\n")
            formals = [lines[p.span.line - 1][p.span.column - 1 : p.span.end_column - 1] for p in parts]
            return f"{name}({', '.join(formals)})", formals, commas
        elif text in ("[", "{"):
            return None
        elif text == "," and not depth:
            commas += 1
    return None


_CALLED = ("fn", "record")
_LOCAL = ("binder",)


def _owner(text: str, token: Lexeme) -> str | None:
    before = text[: token.start].rstrip()
    return _owner_before(before[:-1]) if before.endswith(".") else None


def _owner_before(text: str) -> str | None:
    """Return the name that a dot stands behind, brackets between left out."""
    depth = 0
    for token in reversed(list(lexemes(text[text.rfind("\n") + 1 :]))):
        depth += (token.text == "]") - (token.text == "[")
        if not depth and token.text not in "[]'":
            return token.text
    return None


def _in_instances(document: Document, old: str, new: str) -> list[Edit]:
    """Return the edits of the instance files in a model's folder."""
    path, edits = document.path, []
    for other in sorted(Path(path).parent.glob("*.pomdp")):
        content = document.edited.get(os.path.realpath(other))
        try:
            source = read_source(str(other)) if content is None else decode_source(str(other), content)
            file = parse(source)
        except ModelError:
            continue
        if (
            isinstance(file, ast.InstanceFile)
            and (other.parent / file.model).resolve() == Path(path).resolve()
        ):
            tokens = list(lexemes(source.text))
            edits += [
                Edit(str(other), t.start, t.end, new)
                for t, after in zip(tokens, tokens[1:], strict=False)
                if t.text == old and after.text == "="
            ]
    return edits
