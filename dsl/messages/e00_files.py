# SPDX-License-Identifier: Apache-2.0
"""Texts of E00xx: files that cannot be read or do not belong together, and settings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span


def missing(path: str, siblings: Sequence[str], span: Span | None) -> Diagnostic:
    """A file that is not there; ``siblings`` are the model files of its folder."""
    name = PurePath(path).name
    remedy = did_you_mean(name, siblings) or "check the name and the folder"
    if f"{name}.pomdp" in siblings:
        remedy = f"did you mean '{name}.pomdp'?"
    return Diagnostic("E0001", f"there is no file '{path}'", span, remedy)


def folder(path: str, span: Span | None) -> Diagnostic:
    """A folder where a file is needed."""
    return Diagnostic("E0002", f"'{path}' is a folder, not a file", span, "name a .pomdp file in it")


def unreadable(path: str, reason: str, span: Span | None) -> Diagnostic:
    """A file that the operating system does not give."""
    message = f"'{path}' cannot be read: {reason}"
    return Diagnostic("E0003", message, span, "check the path and its permissions")


def not_utf8(path: str, byte: int, span: Span | None) -> Diagnostic:
    """A text in another encoding; ``byte`` counts from 1."""
    message = f"'{path}' is not a text in UTF-8 (byte {byte} does not fit)"
    return Diagnostic("E0004", message, span, "save the file as UTF-8")


def binary(path: str, span: Span | None) -> Diagnostic:
    """A file with zero bytes."""
    message = f"'{path}' is a binary file, not a text"
    return Diagnostic("E0004", message, span, "name a .pomdp file, saved as UTF-8")


def empty(path: str, span: Span | None) -> Diagnostic:
    """A file without any words."""
    return Diagnostic("E0005", f"'{path}' is empty", span, "start a model with `model Name`")


def too_large(path: str, most_bytes: int, span: Span | None) -> Diagnostic:
    """A file of more than ``most_bytes``."""
    message = f"'{path}' is larger than {most_bytes // 1_000_000} MB"
    remedy = "a model is a description, not a table: declare large tables as params"
    return Diagnostic("E0006", message, span, remedy)


def instance_of_library(path: str, span: Span | None) -> Diagnostic:
    """An instance that names a library at ``span`` as its model."""
    remedy = "name a file that starts with `model Name`"
    return Diagnostic("E0007", f"'{path}' is a library, not a model", span, remedy)


def instance_of_instance(path: str, model: str, span: Span | None) -> Diagnostic:
    """An instance that names an instance of ``model`` at ``span`` as its model."""
    return Diagnostic("E0007", f"'{path}' is an instance, not a model", span, f'write `of "{model}"`')


def not_an_instance(path: str, kind: str) -> Diagnostic:
    """A file of another ``kind`` (``a model``) where an instance is needed."""
    remedy = 'an instance file starts with `instance name of "model.pomdp"`'
    return Diagnostic("E0008", f"'{path}' is {kind}, not an instance", None, remedy)


def instance_of_other(model: str, given: str, expected: str, span: Span | None) -> Diagnostic:
    """An instance of ``model``, in the file ``expected``, that is used with the file ``given``."""
    message = f"this instance belongs to '{model}', not to '{given}'"
    return Diagnostic("E0009", message, span, f"use the instance with '{expected}', or change what it names")


def set_twice(name: str, span: Span, first: Span) -> Diagnostic:
    """An instance that sets a name a second time."""
    return Diagnostic(
        "E0010", f"'{name}' is set twice", span, "keep one of the two", ((first, "set here before"),)
    )


def malformed_setting(setting: str) -> Diagnostic:
    """A setting of the command line that is not ``name=value``."""
    message = f"the setting '{setting}' has no name or no value"
    return Diagnostic("E0011", message, None, "write `name=value`, such as `--set n=11`")


def second_instance(path: str, span: Span) -> Diagnostic:
    """An instance that is given with an instance in the model's place."""
    remedy = "leave the second instance out, or name the model's own file"
    return Diagnostic("E0012", f"'{path}' is an instance already", span, remedy)


def not_a_library(path: str, kind: str, span: Span) -> Diagnostic:
    """An import of another ``kind`` of file (``a model``)."""
    message = f"'{path}' is {kind}, and only libraries can be imported"
    return Diagnostic(
        "E0013", message, span, "move what both need into a file that starts with `library Name`"
    )


def circular_import(files: Sequence[str], span: Span) -> Diagnostic:
    """Imports that lead back to where they started; the first and the last of ``files`` are the same."""
    message = f"the files import each other in a circle: {' -> '.join(files)}"
    remedy = "remove one of the imports; what both files need can stand in a third"
    return Diagnostic("E0014", message, span, remedy)


def library_as_model(path: str, name: str) -> Diagnostic:
    """A library where a model is needed."""
    remedy = "name a model that imports it; `hypgen check FILE` alone checks a library by itself"
    return Diagnostic("E0015", f"'{path}' is the library '{name}', not a model", None, remedy)
