# SPDX-License-Identifier: Apache-2.0
"""All that templates may see: text that is ready to be laid out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Function:
    """A C++ function: comment lines, the head up to its ``{``, and the body."""

    comment: tuple[str, ...]
    head: tuple[str, ...]
    body: tuple[str, ...]


@dataclass(frozen=True)
class Section:
    """Functions that belong together."""

    title: str
    functions: tuple[Function, ...]


@dataclass(frozen=True)
class ValueType:
    """An enum or a record: constants and constructors of its codes."""

    name: str
    members: tuple[str, ...]


@dataclass(frozen=True)
class Words:
    """``Fixed`` or ``State``: how many words of which type, and its accessors."""

    name: str
    purpose: str
    count: int
    members: tuple[str, ...]
    word: str = "std::uint32_t"


@dataclass(frozen=True)
class Lanes:
    """The model's functions in lanes."""

    key: str  # the type of an observation key
    has_history: bool
    types: tuple[ValueType, ...]
    joint: tuple[str, ...]  # members of its struct, if the action has components
    words: tuple[Words, ...]
    functions: tuple[Function, ...]


@dataclass(frozen=True)
class Header:
    """The model's header."""

    banner: str
    name: str
    constants: tuple[str, ...]
    types: tuple[ValueType, ...]
    sites: tuple[str, ...]
    params: tuple[str, ...]
    words: tuple[Words, ...]
    sections: tuple[Section, ...]
    base: str  # what the model's struct derives from, as C++ writes it
    posterior: tuple[str, ...] | None  # members of its struct, if the model has one
    evidence: tuple[str, ...]  # members of its struct, if particles keep units
    moments: bool  # a belief is kept by mean and deviation, or asked for its deviation
    relaxed: bool  # tables of small models bound its rewards
    shares: bool  # and are those of agents that share tokens
    tracks: bool  # its particle filter notes which fixed values were read
    lanes: Lanes | None
    no_lanes: str  # why there are none


@dataclass(frozen=True)
class Main:
    """The descriptor's source file."""

    banner: str
    header: str
    name: str
    functions: tuple[Function, ...]
    settings: tuple[str, ...]
    rounding: tuple[str, ...] = ()


@dataclass(frozen=True)
class Group:
    """Enumerators that belong together."""

    title: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class CGroup:
    """What C programs have of a type: its struct, if it is a record, and functions of its codes."""

    struct: tuple[str, ...]
    functions: tuple[Function, ...]


@dataclass(frozen=True)
class Library:
    """What a library says of the values that its callers give and get."""

    visible: tuple[str, ...]
    seen: tuple[str, ...]
    hidden: tuple[str, ...]
    enumerators: tuple[Group, ...]
    functions: tuple[CGroup, ...]


@dataclass(frozen=True)
class Project:
    """The build files and the page for people."""

    banner: str
    model: str
    stem: str
    target: str
    file: str
    hash: str
    doubtful: tuple[str, ...]  # bounds and rewards that may be no number
