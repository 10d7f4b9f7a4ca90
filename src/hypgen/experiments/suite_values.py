# SPDX-License-Identifier: Apache-2.0
"""Values of a suite's tables: each is as it should be, or an error says where it is and what would do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hypgen.dsl.messages.diagnostic import did_you_mean

MODES = ("default", "rollout", "despot", "parallel", "pomcp", "gpu", "hyp")
THREADED = ("parallel", "hyp")
ON_GPU = ("gpu", "hyp")
BESIDE = ("default", "rollout")  # what a search has to beat


class SuiteError(ValueError):
    """A suite that cannot be played; the text says where and what would do."""


def check_keys(data: Mapping[str, Any], known: Sequence[str], where: str) -> None:
    """Refuse keys that are not known."""
    for key in data:
        if key not in known:
            nearest = did_you_mean(key, known) or f"there are {', '.join(known)}"
            raise SuiteError(f"{where}: unknown key `{key}`: {nearest}")


def table_of(data: Mapping[str, Any], key: str, where: str) -> dict[str, Any]:
    """Return a table, empty where there is none."""
    value = data.get(key, {})
    if not isinstance(value, dict):
        raise SuiteError(f"{where}: `{key}` is a table")
    return value


def text_of(data: Mapping[str, Any], key: str, where: str, default: str | None = None) -> str:
    """Return a text that is not empty; without a default it must be there."""
    value = data.get(key, default)
    if not isinstance(value, str) or not value:
        raise SuiteError(f"{where}: `{key}` is {'a text' if key in data else 'missing'}")
    return value


def strings_of(data: Mapping[str, Any], key: str, where: str, default: list[str]) -> list[str]:
    """Return a list of texts that is not empty."""
    value = data.get(key, default)
    if not isinstance(value, list) or not value or not all(isinstance(one, str) for one in value):
        raise SuiteError(f"{where}: `{key}` is a list of texts")
    return value


def is_number(value: Any) -> bool:
    """Say whether a value is a number: true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def numbers_of(data: Mapping[str, Any], key: str, where: str) -> tuple[tuple[str, float], ...]:
    """Return a table of numbers as pairs."""
    found = table_of(data, key, where)
    if wrong := next((name for name, value in found.items() if not is_number(value)), None):
        raise SuiteError(f"{where}: `{wrong}` is a number")
    return tuple(found.items())


def number_of(data: Mapping[str, Any], key: str, where: str, default: int | None, least: int) -> int:
    """Return a whole number from ``least``; without a default it must be there."""
    value = data.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise SuiteError(
            f"{where}: `{key}` is {f'a whole number from {least}' if key in data else 'missing'}"
        )
    return value
