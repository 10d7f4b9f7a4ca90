# SPDX-License-Identifier: Apache-2.0
"""What a model shows: the names, types and ranges of its values, and their rows of 32-bit integers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Codes = npt.NDArray[np.int32]  # values as hypgen.h has them


@dataclass(frozen=True)
class Field:
    """A visible variable or an observation: one value, or an array of them row by row."""

    name: str
    type: str  # bool, int, float or named
    dims: tuple[int, ...]
    low: float
    high: float
    values: tuple[str, ...]  # the names of codes, where there are not too many

    @property
    def length(self) -> int:
        """How many values it has."""
        return math.prod(self.dims)

    @property
    def names(self) -> list[str]:
        """The name of each value: ``reading``, or ``map[0][2]`` of an array."""
        places = itertools.product(*map(range, self.dims))
        return [self.name + "".join(f"[{i}]" for i in place) for place in places]

    def value(self, code: np.int32) -> bool | int | float | str:
        """Return what a code stands for."""
        if self.type == "bool":
            return bool(code)
        if self.type == "float":
            return float(code.view(np.float32))
        return self.values[code] if self.values else int(code)


def read_fields(described: Iterable[Mapping[str, Any]]) -> tuple[Field, ...]:
    """Return the fields of a model's description."""
    return tuple(
        Field(
            one["name"],
            one["type"],
            tuple(one["dims"]),
            -math.inf if one["low"] is None else one["low"],
            math.inf if one["high"] is None else one["high"],
            tuple(one.get("values", ())),
        )
        for one in described
    )


def named(fields: Sequence[Field], row: Codes) -> dict[str, Any]:
    """Return a row of codes as values by name; an array is a flat list."""
    found: dict[str, Any] = {}
    first = 0
    for field in fields:
        values = [field.value(code) for code in row[first : first + field.length]]
        found[field.name] = values if field.dims else values[0]
        first += field.length
    return found
