# SPDX-License-Identifier: Apache-2.0
"""Answers about a document that need no protocol: hovers, references, completions, signatures."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hypgen.dsl.load import Loaded
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax import ast
from hypgen.editor.document import Declared, Document
from hypgen.editor.facts import facts
from hypgen.editor.forms import FORMS, VALUES
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
    if form := FORMS.get(token.text):
        return "\n".join((*form.calls, f"# {form.gives}"))
    return VALUES.get(token.text, "")


def meant(document: Document, token: Lexeme) -> Declared | None:
    """Return the declaration that a name stands for, or None where two fit alike or none fits."""
    found = [d for d in document.declared() if d.name == token.text]
    owner = _owner(document.text, token)
    inside = document.item_at(document.text.count("\n", 0, token.start) + 1)
    fitting = [d for d in found if d.holder == (owner or inside)]
    if not fitting:
        held = ("field",) if owner else ()  # of a record in a variable
        fitting = [d for d in found if d.holder is None or d.word in ("variant", *held)]
    return fitting[0] if len(fitting) == 1 else None


def references(document: Document, offset: int) -> list[Lexeme]:
    """Return each token of the text that stands, or may stand, for what the name at an offset stands for."""
    token = document.lexeme_at(offset)
    if token is None or token.kind != "NAME":
        return []
    named = [t for t in lexemes(document.text) if t.kind == "NAME" and t.text == token.text]
    target = meant(document, token)
    if target is None:
        return named
    return [t for t in named if (other := meant(document, t)) is None or other.node is target.node]


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
    known += [Item(f, FORMS[f].gives if f in FORMS else "function", f"{f}($0)") for f in table.functions]
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
                return _of_the_language(name, commas)
            parts = node.formals if isinstance(node, ast.Function) else getattr(node, "fields", ())
            lines = document.text_of(node.span.file).split("\n")
            formals = [lines[p.span.line - 1][p.span.column - 1 : p.span.end_column - 1] for p in parts]
            return f"{name}({', '.join(formals)})", formals, commas
        elif text in ("[", "{"):
            return None
        elif text == "," and not depth:
            commas += 1
    return None


def _of_the_language(name: str, commas: int) -> tuple[str, list[str], int] | None:
    """Return the first form of a function of the language that has enough arguments."""
    for call in FORMS[name].calls if name in FORMS else ():
        formals = call[len(name) + 1 : -1].split(", ")
        if len(formals) > commas:
            return call, formals, commas
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
