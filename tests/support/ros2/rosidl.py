# SPDX-License-Identifier: Apache-2.0
"""Reads interface files of ROS 2 by its rules, and writes C++ headers as far as a node needs them."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath

FIELD = re.compile(r"[a-z](_?[a-z0-9])*")  # of packages too
MESSAGE = re.compile(r"[A-Z][A-Za-z0-9]*")
CONSTANT = re.compile(r"[A-Z](_?[A-Z0-9])*")
TYPES = {
    "bool": "bool",
    "int32": "std::int32_t",
    "uint64": "std::uint64_t",
    "float32": "float",
    "float64": "double",
    "string": "std::string",
}
CXX_WORDS = {"and", "auto", "class", "default", "delete", "enum", "new", "not", "or", "operator", "union"}
PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


@dataclass(frozen=True)
class Field:
    """A field or, with ``constant``, a constant of a message."""

    type: str
    length: int | None
    name: str
    value: str
    constant: bool


def read(text: str) -> list[list[Field]]:
    """Return the fields of each part of an interface file; a line that ROS refuses is an error."""
    parts: list[list[Field]] = [[]]
    for line in text.splitlines():
        code = line.partition("#")[0].strip()
        if code == "---":
            parts.append([])
        elif code:
            parts[-1].append(_field(code))
    for part in parts:
        names = [f.name for f in part]
        assert len(names) == len(set(names)), f"a name twice: {names}"
    return parts


def _field(code: str) -> Field:
    match = re.fullmatch(r"([A-Za-z0-9]+)(\[(\d+)\])?\s+(\w+)\s*(=?)\s*(\S*)", code)
    assert match, f"no field: {code}"
    type_, _, length, name, equals, value = match.groups()
    assert type_ in TYPES or MESSAGE.fullmatch(type_), code
    assert (CONSTANT if equals else FIELD).fullmatch(name), code
    assert not keyword.iskeyword(name) and name not in CXX_WORDS, code
    assert length is None or int(length) > 0, code
    return Field(type_, None if length is None else int(length), name, value, bool(equals))


def header_name(message: str) -> str:
    """Return a header's name: an underscore before each word that begins with an upper-case letter."""
    word = re.sub(r"(?<=.)(?=[A-Z][a-z])", "_", message)
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", word).lower()


def headers(files: dict[str, str], package: str) -> dict[str, str]:
    """Return the C++ headers of a message package, by their paths; ``files`` has it by paths."""
    assert FIELD.fullmatch(package), package
    listed = set(re.findall(r'"((?:msg|srv|action)/[^"]+)"', files[f"{package}/CMakeLists.txt"]))
    found = {path.removeprefix(f"{package}/") for path in files if path.endswith((".msg", ".srv", ".action"))}
    assert listed == found, f"not listed, or not there: {listed ^ found}"
    result = {}
    for name in found:
        path = PurePosixPath(name)
        kind, message = path.parts[0], path.stem
        assert MESSAGE.fullmatch(message), message
        target = f"{package}/{kind}/{header_name(message)}.hpp"
        assert target not in result, f"two messages with one header: {target}"
        parts = read(files[f"{package}/{name}"])
        assert len(parts) == len(PARTS[kind]), name
        result[target] = "\n".join(_header(package, kind, message, parts))
    return result


def _header(package: str, kind: str, message: str, parts: list[list[Field]]) -> Iterator[str]:
    yield "#pragma once"
    yield from ("#include <array>", "#include <cstdint>", "#include <string>")
    for type_ in sorted({f.type for part in parts for f in part} - TYPES.keys()):
        yield f"#include <{package}/msg/{header_name(type_)}.hpp>"
    yield f"namespace {package}::{kind} {{"
    yield f"struct {message} {{"
    for name, part in zip(PARTS[kind], parts, strict=True):
        members = [_member(package, f) for f in part]
        yield from ([f"struct {name} {{", *members, "};"] if name else members)
    yield "};"
    yield "}"


def _member(package: str, field: Field) -> str:
    type_ = TYPES.get(field.type, f"{package}::msg::{field.type}")
    if field.constant:
        return f"static constexpr {type_} {field.name} = {field.value};"
    if field.length is not None:
        type_ = f"std::array<{type_}, {field.length}>"
    return f"{type_} {field.name}{{{field.value}}};"
