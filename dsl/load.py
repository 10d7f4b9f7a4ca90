"""From files to a checked model: read, parse, merge the instance and the settings, lower."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from hypgen.dsl import ir
from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError, did_you_mean
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.messages.watch import Watch, nobody
from hypgen.dsl.syntax import ast, imports
from hypgen.dsl.syntax.parse import parse, parse_expression

MAX_BYTES = 4_000_000
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
    watch: Watch = nobody,
) -> Loaded | LoadedLibrary:
    """Return what ``load`` returns, or a library that has been checked by itself; raises ``ModelError``."""
    sources: dict[str, Source] = {}

    def read(path: str, cited: Span) -> ast.File:
        return _read(path, sources, cited)

    try:
        file, assigned = _read_files(os.fspath(path), instance, sources, given)
        watch("parse", file)
        texts = len(sources)
        complete = imports.resolve(file, read)
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
        pipeline.check_library(complete)
        return LoadedLibrary(complete, sources)
    except ModelError as error:
        error.sources = sources | error.sources
        raise


def read_source(path: str, cited: Span | None = None) -> Source:
    """Return a file's text with line ends as ``\\n``; raises ``ModelError``.

    ``cited`` is the place that names the file, if a file does.
    """
    try:
        with open(path, "rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise _failure("E0001", f"there is no file '{path}'", _nearest_file(Path(path)), cited) from None
    except IsADirectoryError:
        remedy = "name a .pomdp file in it"
        raise _failure("E0002", f"'{path}' is a folder, not a file", remedy, cited) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        remedy = "check the path and its permissions"
        raise _failure("E0003", f"'{path}' cannot be read: {reason}", remedy, cited) from None
    return decode_source(path, content, cited)


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
    if len(content) > MAX_BYTES:
        remedy = "a model is a description, not a table: declare large tables as params"
        raise _failure("E0006", f"'{path}' is larger than {MAX_BYTES // 1_000_000} MB", remedy, cited)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"'{path}' is not a text in UTF-8 (byte {error.start + 1} does not fit)"
        raise _failure("E0004", message, "save the file as UTF-8", cited) from None
    if "\0" in text:
        remedy = "name a .pomdp file, saved as UTF-8"
        raise _failure("E0004", f"'{path}' is a binary file, not a text", remedy, cited)
    if not text.strip():
        raise _failure("E0005", f"'{path}' is empty", "start a model with `model Name`", cited)
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n"))


def _read_files(
    path: str, instance: FilePath | None, sources: dict[str, Source], given: Source | None
) -> tuple[ast.ModelFile | ast.LibraryFile, tuple[ast.Assignment, ...]]:
    """Return the model and the instance's assignments, whichever of the two ``path`` names; or a library."""
    if given is not None:
        sources[given.name] = given
    file = _read(path, sources) if given is None else parse(given)
    if isinstance(file, ast.LibraryFile):
        return file, ()
    if isinstance(file, ast.ModelFile):
        return file, () if instance is None else _read_instance(os.fspath(instance), path, sources)
    if instance is not None:
        remedy = "leave the second instance out, or name the model's own file"
        raise _failure("E0012", f"'{path}' is an instance already", remedy, file.span)
    model_path = _model_path(file)
    model = _read(model_path, sources, file.model_span)
    if not isinstance(model, ast.ModelFile):
        remedy, kind = "name a file that starts with `model Name`", "a library"
        if isinstance(model, ast.InstanceFile):
            remedy, kind = f'write `of "{model.model}"`', "an instance"
        raise _failure("E0007", f"'{model_path}' is {kind}, not a model", remedy, file.model_span)
    return model, _assignments(file)


def _read_instance(path: str, model_path: str, sources: dict[str, Source]) -> tuple[ast.Assignment, ...]:
    file = _read(path, sources)
    if not isinstance(file, ast.InstanceFile):
        remedy = 'an instance file starts with `instance name of "model.pomdp"`'
        kind = "a model" if isinstance(file, ast.ModelFile) else "a library"
        raise _failure("E0008", f"'{path}' is {kind}, not an instance", remedy, None)
    expected = _model_path(file)
    if not os.path.exists(expected) or not os.path.samefile(expected, model_path):
        remedy = f"use the instance with '{expected}', or change what it names"
        message = f"this instance belongs to '{file.model}', not to '{model_path}'"
        raise _failure("E0009", message, remedy, file.model_span)
    return _assignments(file)


def _read(path: str, sources: dict[str, Source], cited: Span | None = None) -> ast.File:
    sources[path] = read_source(path, cited)
    return parse(sources[path])


def _model_path(file: ast.InstanceFile) -> str:
    return os.path.join(os.path.dirname(file.span.file), file.model)


def _assignments(file: ast.InstanceFile) -> tuple[ast.Assignment, ...]:
    first: dict[str, ast.Assignment] = {}
    twice = [a for a in file.assignments if first.setdefault(a.name, a) is not a]
    if twice:
        raise ModelError(
            Diagnostic(
                "E0010",
                f"'{a.name}' is set twice",
                a.span,
                "keep one of the two",
                ((first[a.name].span, "set here before"),),
            )
            for a in twice
        )
    return file.assignments


def _parse_settings(settings: Iterable[str], sources: dict[str, Source]) -> dict[str, ast.Expr]:
    result: dict[str, ast.Expr] = {}
    for setting in settings:
        match = _SETTING.fullmatch(setting)
        if match is None or not match[2].strip():
            remedy = "write `name=value`, such as `--set n=11`"
            raise _failure("E0011", f"the setting '{setting}' has no name or no value", remedy, None)
        source = Source(f"--set {match[1]}", match[2])
        sources[source.name] = source
        result[match[1]] = parse_expression(source)
    return result


def _not_a_model(file: ast.LibraryFile) -> ModelError:
    message = f"'{file.span.file}' is the library '{file.name}', not a model"
    remedy = "name a model that imports it; `hypgen check FILE` alone checks a library by itself"
    return _failure("E0015", message, remedy, None)


def _nearest_file(path: Path) -> str:
    """Return a remedy for a file that is not there: what its folder has instead."""
    try:
        names = [p.name for p in path.parent.iterdir() if p.suffix == ".pomdp"]
    except OSError:
        return "check the name and the folder"
    if f"{path.name}.pomdp" in names:
        return f"did you mean '{path.name}.pomdp'?"
    return did_you_mean(path.name, names) or "check the name and the folder"


def _failure(code: str, message: str, remedy: str, span: Span | None) -> ModelError:
    return ModelError([Diagnostic(code, message, span, remedy)])
