# SPDX-License-Identifier: Apache-2.0
"""``import``: the declarations of libraries, and of what they import, in the order of the text."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace

from hypgen.dsl.messages import e00_files
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast

File = ast.ModelFile | ast.LibraryFile
Reader = Callable[[str, Span], ast.ModelFile | ast.LibraryFile | ast.InstanceFile]


def resolve(file: File, read: Reader) -> File:
    """Return ``file`` with what it imports in the place of its imports; a library counts once.

    ``read`` parses the file at a path, which the text at the given place names. Raises ``ModelError`` with
    the mistakes of all imports.
    """
    resolver = _Resolver(read)
    items = resolver.items(file, [file.span.file])
    if resolver.found:
        raise ModelError(resolver.found)
    return replace(file, items=items)


class _Resolver:
    def __init__(self, read: Reader) -> None:
        self.found: list[Diagnostic] = []
        self._read = read
        self._done: set[str] = set()

    def items(self, file: File, chain: list[str]) -> tuple[ast.Item, ...]:
        """Return the file's items; ``chain`` has the paths of the files that led here, itself the last."""
        result: list[ast.Item] = []
        for item in file.items:
            if not isinstance(item, ast.Import):
                result.append(item)
                continue
            try:
                result += self._imported(item, chain)
            except ModelError as error:
                self.found += error.diagnostics
        return tuple(result)

    def _imported(self, item: ast.Import, chain: list[str]) -> tuple[ast.Item, ...]:
        path = os.path.join(os.path.dirname(item.span.file), item.path)
        file = os.path.realpath(path)
        active = [os.path.realpath(p) for p in chain]
        if file in active:
            raise _cycle(item, [*chain[active.index(file) :], path])
        if file in self._done:
            return ()
        self._done.add(file)
        imported = self._read(path, item.path_span)
        if not isinstance(imported, ast.LibraryFile):
            kind = "a model" if isinstance(imported, ast.ModelFile) else "an instance"
            raise ModelError([e00_files.not_a_library(path, kind, item.path_span)])
        return self.items(imported, [*chain, path])


def _cycle(item: ast.Import, cycle: list[str]) -> ModelError:
    names = [os.path.basename(p) for p in cycle]
    return ModelError([e00_files.circular_import(names, item.path_span)])
