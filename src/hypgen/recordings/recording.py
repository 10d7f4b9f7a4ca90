# SPDX-License-Identifier: Apache-2.0
"""The parts of a recording. Values of variables are as ``--start`` takes them, arrays flat and row-major."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Variable:
    """A variable of the model. ``type`` is bool, int, float or named; ``values`` are the names of codes.

    ``values`` is empty for other types, and where there are more than 4,096 names.
    """

    name: str
    type: str
    dims: tuple[int, ...]
    values: tuple[str, ...]
    visible: bool


@dataclass(frozen=True)
class Header:
    """What holds for all episodes. ``params`` are the world's; ``options`` are those of the solver's run."""

    model: str
    hash: str
    file: str
    discount: float
    horizon: int | None
    options: Mapping[str, Any]
    params: Mapping[str, Any]
    actions: tuple[str, ...]
    variables: tuple[Variable, ...]
    line: Mapping[str, Any]


@dataclass(frozen=True)
class Start:
    """The start of an episode, and the values that the agent sees then."""

    episode: int
    visible: Mapping[str, Any]


@dataclass(frozen=True)
class Step:
    """A step: what was true and believed before the action, what the search found, and what came of it.

    ``sampled`` has states of the belief by hidden variable, a value for each state. ``tree`` has
    ``tree_shown`` of ``tree_total`` beliefs and actions; it is None where no tree decided. ``seen`` is None
    after a last step. ``line`` has everything, as in the lines of ``--json``.
    """

    episode: int
    step: int
    action: int
    action_name: str
    default_action: str | None
    reward: float
    terminal: bool
    seen: Mapping[str, Any] | None
    state: Mapping[str, Any]
    sampled: Mapping[str, list[Any]] | None
    particles_total: int | None
    marginals: list[Mapping[str, Any]] | None
    tree: Mapping[str, Any] | None
    tree_shown: int
    tree_total: int
    line: Mapping[str, Any]


@dataclass(frozen=True)
class End:
    """The end of an episode: its returns, why it ended, and the last state."""

    episode: int
    steps: int
    discounted_return: float
    status: str
    terminal: bool
    state: Mapping[str, Any]
    line: Mapping[str, Any]


def header_of(line: Mapping[str, Any]) -> Header:
    """Return the header that a first line holds; ``KeyError`` and ``TypeError`` mean that it is none."""
    variables = tuple(
        Variable(v["name"], v["type"], tuple(v["dims"]), tuple(v.get("values", ())), v["visible"])
        for v in line["variables"]
    )
    return Header(
        line["model"],
        line["hash"],
        line["file"],
        line["discount"],
        line["horizon"],
        line["options"],
        line["params"],
        tuple(line["actions"]),
        variables,
        line,
    )


def step_of(line: Mapping[str, Any]) -> Step:
    """Return the step that a line holds; ``KeyError`` and ``TypeError`` mean that it is none."""
    return Step(**{name: line[name] for name in Step.__dataclass_fields__ if name != "line"}, line=line)


def end_of(line: Mapping[str, Any]) -> End:
    """Return the end that a line holds; ``KeyError`` and ``TypeError`` mean that it is none."""
    return End(**{name: line[name] for name in End.__dataclass_fields__ if name != "line"}, line=line)
