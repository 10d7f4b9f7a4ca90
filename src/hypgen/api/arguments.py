# SPDX-License-Identifier: Apache-2.0
"""What callers give, as C takes it: ctypes would cut off numbers that do not fit, and end texts at a NUL."""

from __future__ import annotations

import json
import math
import operator
from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from hypgen.api.c_interface import PlannerError


def in_range(name: str, value: Any, low: int, high: int) -> int:
    """Return an integer, of Python or numpy, within its limits."""
    number = _integer(value)
    if number is None or not low <= number <= high:
        raise _refused(name, f"an integer from {low} to {high}", value)
    return number


def real(name: str, value: Any) -> float:
    """Return a finite number."""
    if not isinstance(value, Real) or not math.isfinite(value):
        raise _refused(name, "a number", value)
    return float(value)


def encoded(name: str, text: Any) -> bytes:
    """Return a text."""
    if not isinstance(text, str):
        raise _refused(name, "a text", text)
    if "\0" in text:
        raise PlannerError("wrong_argument", f"{name}: has a NUL")
    return text.encode()


def encoded_object(name: str, values: Any) -> bytes:
    """Return values by name as JSON; numpy's are those of Python."""
    if not isinstance(values, Mapping):
        raise _refused(name, "values by name", values)

    def plain(value: Any) -> Any:
        if isinstance(value, np.generic | np.ndarray):
            return value.tolist()
        raise _refused(name, "bools, numbers, texts and lists of them", value)

    return json.dumps(dict(values), default=plain).encode()


def words(name: str, key: Any) -> list[int]:
    """Return the words of a key: a number or several."""
    number = _integer(key)
    if number is None and (isinstance(key, str) or not hasattr(key, "__iter__")):
        raise _refused(name, "values by name, or a key", key)
    return [in_range("key", word, 0, 2**64 - 1) for word in ([key] if number is not None else key)]


def _integer(value: Any) -> int | None:
    try:
        return operator.index(value)
    except TypeError:
        return None


def _refused(name: str, expected: str, found: Any) -> PlannerError:
    return PlannerError("wrong_argument", f"{name}: expected {expected}, found {found!r}")
