# SPDX-License-Identifier: Apache-2.0
"""All that the templates of ROS 2 packages may see."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Field:
    """A field of a message: a comment, its type, its name."""

    comment: str
    type: str
    name: str


@dataclass(frozen=True)
class EnumMessage:
    """A message of a code with a constant for each variant; ``header`` is its C++ header's name."""

    name: str
    header: str
    title: str
    constants: tuple[str, ...]


@dataclass(frozen=True)
class RecordMessage:
    """A message of a record's fields. ``digits`` is C++ that adds each field to the record's code."""

    name: str
    header: str
    title: str
    fields: tuple[Field, ...]
    digits: tuple[str, ...]


@dataclass(frozen=True)
class Parameter:
    """A parameter of the node: its name, its name in hypgen, and what it is."""

    name: str
    key: str
    text: str


@dataclass(frozen=True)
class Packages:
    """The message package and the planner's package. ``stem`` begins their names."""

    stem: str
    enums: tuple[EnumMessage, ...]
    records: tuple[RecordMessage, ...]
    seen: tuple[Field, ...]
    visible: tuple[Field, ...]
    statuses: tuple[str, ...]
    action: str  # what the numbers of actions are
    start_is_drawn: bool  # draws decide what is visible at the start, so that the caller has to say it
    params: tuple[Parameter, ...]
    declarations: tuple[str, ...]  # lines of C++ that declare the params
    settings: tuple[Parameter, ...]
