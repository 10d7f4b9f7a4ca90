# SPDX-License-Identifier: Apache-2.0
"""Renames: token by token, here and in the files that share the name, and tried before they are made."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from hypgen.dsl.load import Loaded, decode_source, read_source
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse
from hypgen.editor.answers import at, is_elsewhere, meant, references
from hypgen.editor.document import Checked, Declared, Document, citation
from hypgen.editor.words import lexemes

_SET_BY_INSTANCES = ("const", "param")
_NO_MEANING = re.compile(r"Span\([^()]*\)|source_hash='\w*'")


@dataclass(frozen=True)
class Edit:
    """A text in the place of that between two offsets of a file."""

    path: str
    start: int
    end: int
    text: str


class RenameRefused(Exception):
    """A rename would change what the model means, or cannot be known not to."""


def rename(document: Document, offset: int, new: str) -> list[Edit]:
    """Return the edits that rename a name here, in its library and in files beside.

    The results have to pass the checker. Where other declarations have the same name, the model has to mean
    the same as before. ``RenameRefused`` otherwise.
    """
    token = document.lexeme_at(offset)
    declared = at(document, offset)
    if token is None or not declared:
        raise RenameRefused("there is no name of the model here")
    old = token.text
    if [t.kind for t in lexemes(new)] != ["NAME"]:
        raise RenameRefused(f"'{new}' cannot be a name")
    if _is_wrong(document.current()):
        raise RenameRefused("the model has mistakes: correct them first")
    target = declared[0] if len(declared) == 1 else meant(document, token)
    if target is None:
        raise RenameRefused(f"'{old}' is declared in {len(declared)} places: rename them by hand")
    if any(t.text == new for t in lexemes(document.text)) or any(d.name == new for d in document.declared()):
        raise RenameRefused(f"'{new}' is taken")
    if is_elsewhere(document, target) or isinstance(document.tree, ast.LibraryFile):
        return _in_library(document, target, new)
    edits = [Edit(document.path, t.start, t.end, new) for t in references(document, offset)]
    before, after = document.current(), document.examine(_edited(document.text, edits))
    if _is_wrong(after):
        raise RenameRefused(f"the model would have mistakes with '{new}'")
    if len(declared) > 1 and _meaning(after, new, old) != _meaning(before, new, old):
        raise RenameRefused(f"'{old}' is declared in {len(declared)} places: rename them by hand")
    if target.word in _SET_BY_INSTANCES:
        edits += _in_instances(document, old, new)
    return edits


def _is_wrong(checked: Checked) -> bool:
    return any(d.severity == "error" for d in checked.found)


def _meaning(checked: Checked, new: str, old: str) -> str:
    """Return the model without places, one name in the place of the other."""
    model = checked.loaded.model if isinstance(checked.loaded, Loaded) else None
    return re.sub(rf"\b{re.escape(new)}\b", old, _NO_MEANING.sub("", repr(model)))


def _edited(text: str, edits: list[Edit]) -> str:
    for edit in sorted(edits, key=lambda e: -e.start):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text


def _in_library(document: Document, target: Declared, new: str) -> list[Edit]:
    """Return the edits of a library that declares a name, and of all in the folders that imports it."""
    library = target.node.span.file
    folders = {Path(path).resolve().parent for path in (library, document.path)}
    others = {Source(document.path, document.text).name: Source(document.path, document.text)}
    for source in _beside(document, folders):
        others.setdefault(source.name, source)
    texts = {s.name: s for s in others.values() if _takes_in(s, others, library)}
    edits: dict[str, list[Edit]] = {}
    for name, source in texts.items():
        tokens = list(lexemes(source.text))
        if any(t.text == new for t in tokens):
            raise RenameRefused(f"'{new}' is taken in {os.path.basename(name)}")
        edits[name] = [
            Edit(name, t.start, t.end, new) for t in tokens if t.kind == "NAME" and t.text == target.name
        ]
    renamed = {name: _edited(source.text, edits[name]) for name, source in texts.items()}
    saved = {os.path.realpath(name): text.encode() for name, text in renamed.items()}
    for name, source in texts.items():
        before = Document(name, source.text, document.edited)
        after = Document(name, renamed[name], {**document.edited, **saved})
        before.check()
        if sum(d.name == target.name for d in before.declared()) > 1:
            raise RenameRefused(f"'{target.name}' is declared again in {os.path.basename(name)}")
        if _is_wrong(after.examine(renamed[name])):
            raise RenameRefused(f"{os.path.basename(name)} would have mistakes with '{new}'")
    return [edit for some in edits.values() for edit in some]


def _takes_in(source: Source, others: Mapping[str, Source], library: str) -> bool:
    if os.path.realpath(source.name) == os.path.realpath(library):
        return True
    return citation(Checked(source.text, (), sources=others), source.name, library) is not None


def _beside(document: Document, folders: set[Path]) -> Iterator[Source]:
    """Yield the texts of the files in some folders, as editors have them."""
    for folder in sorted(folders):
        for path in sorted(folder.glob("*.pomdp")):
            content = document.edited.get(os.path.realpath(path))
            try:
                source = read_source(str(path)) if content is None else decode_source(str(path), content)
            except ModelError:
                continue
            if os.path.realpath(path) != os.path.realpath(document.path):
                yield source


def _in_instances(document: Document, old: str, new: str) -> list[Edit]:
    """Return the edits of the instance files in a model's folder."""
    path, edits = document.path, []
    for source in _beside(document, {Path(path).resolve().parent}):
        try:
            file = parse(source)
        except ModelError:
            continue
        folder = Path(source.name).parent
        if isinstance(file, ast.InstanceFile) and (folder / file.model).resolve() == Path(path).resolve():
            tokens = list(lexemes(source.text))
            edits += [
                Edit(source.name, t.start, t.end, new)
                for t, after in zip(tokens, tokens[1:], strict=False)
                if t.text == old and after.text == "="
            ]
    return edits
