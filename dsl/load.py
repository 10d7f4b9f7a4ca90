# SPDX-License-Identifier: Apache-2.0
"""From files to a checked model: read, parse, merge the instance and the settings, lower."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hypgen.dsl import ir
from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.messages import e00_files, e01_syntax
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.input_file import read_file
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.messages.watch import Watch, nobody
from hypgen.dsl.syntax import ast, imports
from hypgen.dsl.syntax.parse import parse, parse_expression

MAX_BYTES = 16_000_000
_HEAD = 65_536

_SETTING = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)\s*=(?!=)(.*)", re.DOTALL)

FilePath = str | os.PathLike[str]


@dataclass(frozen=True)
class Loaded:
    """A model and what it was made from: its file with what it imports, and every text read, by name."""

    model: ir.Model
    ast: ast.ModelFile
    sources: dict[str, Source]
    warnings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class LoadedLibrary:
    """A library that has no mistakes; ``sources`` holds every text read, by name."""

    ast: ast.LibraryFile
    sources: dict[str, Source]


def load(
    path: FilePath,
    *,
    instance: FilePath | None = None,
    settings: Iterable[str] = (),
    given: Source | None = None,
    watch: Watch = nobody,
) -> Loaded:
    """Return the checked model of ``path``, which may be an instance file itself; raises ``ModelError``.

    ``settings`` are ``name=value`` texts. They win over the instance, and the last of a name wins. ``given``
    stands for the content of ``path``, such as a text made from it. ``watch`` sees what
    each pass makes of the text.
    """
    loaded = load_any(path, instance=instance, settings=settings, given=given, watch=watch)
    if isinstance(loaded, Loaded):
        return loaded
    raise _not_a_model(loaded.ast)


def load_any(
    path: FilePath,
    *,
    instance: FilePath | None = None,
    settings: Iterable[str] = (),
    given: Source | None = None,
    edited: Mapping[str, bytes] | None = None,
    watch: Watch = nobody,
) -> Loaded | LoadedLibrary:
    """Return what ``load`` returns, or a library that has been checked by itself; raises ``ModelError``.

    ``edited`` has contents that stand for those of files, by real path, such as what editors have not saved.
    """
    files = _Files(edited or {})
    sources = files.sources
    try:
        file, assigned = _read_files(os.fspath(path), instance, files, given)
        watch("parse", file)
        texts = len(sources)
        complete = imports.resolve(file, files.read)
        watch("resolve-imports", complete)
        imported = list(sources.values())[texts:]
        overrides = {a.name: a.value for a in assigned} | _parse_settings(settings, sources)
        from hypgen.dsl import pipeline  # large, and nothing that only reads texts needs it

        if isinstance(complete, ast.ModelFile):
            warned: list[Diagnostic] = []
            model = pipeline.lower(complete, overrides, sources[file.span.file], imported, warned, watch)
            return Loaded(model, complete, sources, tuple(warned))
        if overrides or instance is not None:
            raise _not_a_model(complete)
        pipeline.check_library(complete, watch)
        return LoadedLibrary(complete, sources)
    except ModelError as error:
        error.sources = sources | error.sources
        raise


def read_source(path: str, cited: Span | None = None) -> Source:
    """Return a file's text with line ends as ``\\n``; raises ``ModelError``.

    ``cited`` is the place that names the file, if a file does.
    """
    return decode_source(path, read_content(path, cited), cited)


def read_content(path: str, cited: Span | None = None) -> bytes:
    """Return a file's bytes, or as many as tell that there are too many; raises ``ModelError``."""
    try:
        return read_file(path, MAX_BYTES)
    except FileNotFoundError:
        raise ModelError([e00_files.missing(path, _models_beside(Path(path)), cited)]) from None
    except IsADirectoryError:
        raise ModelError([e00_files.folder(path, cited)]) from None
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise ModelError([e00_files.unreadable(path, reason, cited)]) from None


def decode_source(path: str, content: bytes, cited: Span | None = None) -> Source:
    """Return what ``read_source`` does for a file's content."""
    try:
        return _decoded(path, content, cited)
    except ModelError:
        head = Source(path, content[:_HEAD].decode("latin-1"))
        foreign = recognise(head)  # those may be larger, and in other encodings
        if foreign is None or "\0" in head.text:
            raise
        raise ModelError([foreign], {path: head}) from None


def _decoded(path: str, content: bytes, cited: Span | None) -> Source:
    if b"\0" in content[:_HEAD]:
        raise ModelError([e00_files.binary(path, cited)])
    if len(content) > MAX_BYTES:
        raise ModelError([e00_files.too_large(path, MAX_BYTES, cited)])
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ModelError([e00_files.not_utf8(path, error.start + 1, cited)]) from None
    if "\0" in text:
        raise ModelError([e00_files.binary(path, cited)])
    if not text.strip():
        raise ModelError([e00_files.empty(path, cited)])
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n"))


@dataclass(frozen=True)
class _Files:
    """The texts read so far, by name, and what stands for files that are being edited."""

    edited: Mapping[str, bytes]
    sources: dict[str, Source] = field(default_factory=dict)

    def read(self, path: str, cited: Span | None = None) -> ast.File:
        """Return the tree of a file, which ``cited`` names if a file does; raises ``ModelError``."""
        content = self.edited.get(os.path.realpath(path)) if self.edited else None
        source = read_source(path, cited) if content is None else decode_source(path, content, cited)
        self.sources[path] = source
        foreign = None if cited is None else recognise(source)
        if foreign is not None and cited is not None:
            raise ModelError([e01_syntax.named_foreign_file(foreign, path, cited)])
        return parse(source)


def _read_files(
    path: str, instance: FilePath | None, files: _Files, given: Source | None
) -> tuple[ast.ModelFile | ast.LibraryFile, tuple[ast.Assignment, ...]]:
    """Return the model and the instance's assignments, whichever of the two ``path`` names; or a library."""
    if given is not None:
        files.sources[given.name] = given
    file = files.read(path) if given is None else parse(given)
    if isinstance(file, ast.LibraryFile):
        return file, ()
    if isinstance(file, ast.ModelFile):
        return file, () if instance is None else _read_instance(os.fspath(instance), path, files)
    if instance is not None:
        raise ModelError([e00_files.second_instance(path, file.span)])
    model_path = _model_path(file)
    model = files.read(model_path, file.model_span)
    if isinstance(model, ast.InstanceFile):
        raise ModelError([e00_files.instance_of_instance(model_path, model.model, file.model_span)])
    if isinstance(model, ast.LibraryFile):
        raise ModelError([e00_files.instance_of_library(model_path, file.model_span)])
    return model, _assignments(file)


def _read_instance(path: str, model_path: str, files: _Files) -> tuple[ast.Assignment, ...]:
    file = files.read(path)
    if not isinstance(file, ast.InstanceFile):
        kind = "a model" if isinstance(file, ast.ModelFile) else "a library"
        raise ModelError([e00_files.not_an_instance(path, kind)])
    expected = _model_path(file)
    if not os.path.exists(expected) or not os.path.samefile(expected, model_path):
        raise ModelError([e00_files.instance_of_other(file.model, model_path, expected, file.model_span)])
    return _assignments(file)


def _model_path(file: ast.InstanceFile) -> str:
    return os.path.join(os.path.dirname(file.span.file), file.model)


def _assignments(file: ast.InstanceFile) -> tuple[ast.Assignment, ...]:
    first: dict[str, ast.Assignment] = {}
    twice = [a for a in file.assignments if first.setdefault(a.name, a) is not a]
    if twice:
        raise ModelError(e00_files.set_twice(a.name, a.span, first[a.name].span) for a in twice)
    return file.assignments


def _parse_settings(settings: Iterable[str], sources: dict[str, Source]) -> dict[str, ast.Expr]:
    result: dict[str, ast.Expr] = {}
    for setting in settings:
        match = _SETTING.fullmatch(setting)
        if match is None or not match[2].strip():
            raise ModelError([e00_files.malformed_setting(setting)])
        source = Source(f"--set {match[1]}", match[2])
        sources[source.name] = source
        result[match[1]] = parse_expression(source)
    return result


def _not_a_model(file: ast.LibraryFile) -> ModelError:
    return ModelError([e00_files.library_as_model(file.span.file, file.name)])


def _models_beside(path: Path) -> list[str]:
    """Return the names of the model files in a file's folder, as far as it can be read."""
    try:
        return [p.name for p in path.parent.iterdir() if p.suffix == ".pomdp"]
    except OSError:
        return []
