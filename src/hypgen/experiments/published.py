# SPDX-License-Identifier: Apache-2.0
"""What others say that planners reached, as a suite has it beside its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hypgen.experiments.suite_values import MODES, SuiteError, check_keys, is_number, numbers_of, text_of

QUANTITIES = ("return", "success", "steps", "seconds", "expansions", "speed_up")  # that others publish
_PUBLISHED = ("task", "label", "mode", "at", *QUANTITIES, "interval", "measured", "source", "differs")


@dataclass(frozen=True)
class Published:
    """What others say that a planner reached on a task.

    ``at`` has the options that place it on a figure's axis. ``values`` has what of it is known: ``return``,
    ``success`` and so on, and the study's measures by name. ``interval`` is of the return. ``differs`` says
    what is not as in the study.
    """

    task: str
    label: str
    source: str
    differs: str
    mode: str = ""
    at: tuple[tuple[str, float], ...] = ()
    values: tuple[tuple[str, float], ...] = ()
    interval: tuple[float, float] | None = None


def publication_of(text: Any, played: Mapping[str, str], measures: Sequence[str], where: str) -> Published:
    """Return published values; ``played`` has the names of the study's tasks by their keys."""
    if not isinstance(text, dict):
        raise SuiteError(f"{where}: published values are written as [[study.published]]")
    check_keys(text, _PUBLISHED, where)
    task = text_of(text, "task", where)
    if task not in played:
        raise SuiteError(f"{where}: the study plays no task {task!r}; it plays {', '.join(played)}")
    mode = text.get("mode", "")
    if mode and mode not in MODES:
        raise SuiteError(f"{where}: there is no mode {mode!r}; there are {', '.join(MODES)}")
    values = numbers_of({"values": {key: text[key] for key in QUANTITIES if key in text}}, "values", where)
    measured = numbers_of(text, "measured", where)
    if unknown := next((name for name, _ in measured if name not in measures), None):
        raise SuiteError(f"{where}: the study has no measure {unknown!r}")
    if not (values or measured):
        raise SuiteError(f"{where}: expected at least one of {', '.join(QUANTITIES)}, measured")
    if not 0.0 <= dict(values).get("success", 0.0) <= 1.0:
        raise SuiteError(f"{where}: `success` is a share from 0 to 1")
    return Published(
        played[task],
        text_of(text, "label", where),
        text_of(text, "source", where),
        text_of(text, "differs", where),
        mode,
        numbers_of(text, "at", where),
        values + measured,
        _interval(text, where),
    )


def _interval(text: Mapping[str, Any], where: str) -> tuple[float, float] | None:
    """Return an interval that is written as its half width, or as [low, high]."""
    given = text.get("interval")
    if given is None:
        return None
    if is_number(given) and given >= 0 and "return" in text:
        return text["return"] - given, text["return"] + given
    if isinstance(given, list) and len(given) == 2 and all(map(is_number, given)) and given[0] <= given[1]:
        return given[0], given[1]
    raise SuiteError(f"{where}: `interval` is the half width of that of `return`, or [low, high]")
