# SPDX-License-Identifier: Apache-2.0
"""Prints trees of dataclasses: a node stands on one line if it fits, otherwise one field a line."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping

from hypgen.dsl.ir import Site
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Enum, Record, Type, Variant

WIDTH = 110


def dump(value: object, label: str = "") -> str:
    """Return ``value`` as indented text, which starts with ``label``.

    Types appear as the language writes them: after a colon on a node of the IR. Spans are shown where a
    node is broken over lines, as line:column.
    """
    return "\n".join(_lines(value, "", label))


def _lines(value: object, indent: str, label: str) -> Iterator[str]:
    """Yield the lines of ``value``, the first starting with ``label``."""
    flat = _flat(value)
    compound = _is_node(value) or isinstance(value, tuple | Mapping)
    if len(indent) + len(label) + len(flat) <= WIDTH or not compound:
        yield f"{indent}{label}{flat}"
        return
    if isinstance(value, tuple):
        yield f"{indent}{label or '-'}".rstrip()
        for item in value:
            yield from _lines(item, indent + "  ", "")
        return
    if isinstance(value, Mapping):
        yield f"{indent}{label}".rstrip()
        for key, item in value.items():
            yield from _lines(item, indent + "  ", f"{key}: ")
        return
    yield f"{indent}{label}{_head(value)}{_place(value)}"
    for name, item in _fields(value):
        yield from _lines(item, indent + "  ", f"{name}: ")


def _flat(value: object) -> str:
    """Return ``value`` on one line."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_flat(item)}' for key, item in value.items())}}}"
    if isinstance(value, tuple | frozenset | list):
        items = sorted(value) if isinstance(value, frozenset) else value
        return f"[{', '.join(map(_flat, items))}]"
    if isinstance(value, Site):
        return value.path
    if isinstance(value, Span):
        return f"{value.line}:{value.column}"
    if isinstance(value, ast.Name):
        return value.name
    if isinstance(value, ast.Literal):
        return repr(value.value)
    if not _is_node(value):
        return str(value)
    inner = ", ".join(_flat(item) for _, item in _fields(value))
    return f"{_head(value)}({inner})" if inner else _head(value)


def _declaration(declared: Enum | Record) -> str:
    """Return an enum or record as it would be declared; everywhere else its name stands for it."""
    if isinstance(declared, Enum):
        return f"enum {declared.name} {{ {', '.join(map(_variant, declared.variants))} }}"
    return f"record {declared.name} {{ {', '.join(f'{name}: {of}' for name, of in declared.fields)} }}"


def _variant(variant: Variant) -> str:
    """Return a variant as it would be declared."""
    argument = "" if variant.argument is None else f"({variant.argument})"
    return f"{variant.name}{argument}" + ("" if variant.glyph is None else f' "{variant.glyph}"')


def _is_node(value: object) -> bool:
    """Return whether ``value`` is shown as a tree: types, spans and sites have a text of their own."""
    return dataclasses.is_dataclass(value) and not isinstance(value, Type | Span | Site)


def _head(value: object) -> str:
    """Return a node's class, with the type of an expression of the IR."""
    kind = getattr(value, "type", None)
    return f"{type(value).__name__}{{{kind}}}" if isinstance(kind, Type) else type(value).__name__


def _place(value: object) -> str:
    """Return where a node stands in the text, if it says so."""
    span = getattr(value, "span", None)
    return f"  # {span.line}:{span.column}" if isinstance(span, Span) else ""


def _fields(value: object) -> Iterator[tuple[str, object]]:
    """Yield the fields to show, in order of declaration; a flag is shown as its name where it is set."""
    for field in dataclasses.fields(value):  # type: ignore[arg-type]  # _is_node has checked it
        item = getattr(value, field.name)
        hidden = isinstance(item, Span | dict) or (field.name == "type" and isinstance(item, Type))
        if hidden or item is None or item == () or (field.type == "bool" and not item):
            continue
        shown = field.name if field.type == "bool" else item
        if field.name in ("enums", "records"):
            shown = tuple(map(_declaration, item))
        yield field.name, shown
