# SPDX-License-Identifier: Apache-2.0
"""Reads the table that ``--trace`` of a generated program writes and compares it with the interpreter's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.trace import columns

Table = npt.NDArray[np.int64]


def read(path: Path, model: ir.Model) -> Table:
    """Return a trace file's rows."""
    width = len(columns(model))
    values = np.fromfile(path, dtype="<i8")
    if values.size % width:
        raise ValueError(
            f"{path.name} holds {values.size} numbers, no multiple of the {width} columns of {model.name}"
        )
    return values.reshape(-1, width).astype(np.int64)


def difference(expected: Table, actual: Table, model: ir.Model, scenarios: int) -> str | None:
    """Return where two traces first differ, in words, or None if they are equal."""
    if expected.shape != actual.shape:
        return f"expected a table of shape {expected.shape}, got {actual.shape}"
    places = np.argwhere(expected != actual)
    if not len(places):
        return None
    row, column = (int(i) for i in places[0])
    step, scenario = divmod(row, scenarios)
    names = columns(model)
    want, got = (_show(names[column], table[row, column]) for table in (expected, actual))
    lines = [
        f"first difference in row {row} (step {step}, scenario {scenario}), column '{names[column]}':",
        f"expected {want}, got {got}",
        f"{len(places)} values in {len(np.unique(places[:, 0]))} rows differ",
        "that row of both:",
    ]
    pairs = zip(names, expected[row], actual[row], strict=True)
    lines += [
        f"  {name:24} {_show(name, a)}" + ("" if a == b else f" | {_show(name, b)}") for name, a, b in pairs
    ]
    return "\n".join(lines)


def _show(name: str, value: np.int64) -> str:
    """Return a value as a person reads it: floats beside their bits, rewards beside their fixed point."""
    if name in ("upper", "tail", "lower"):
        return f"{int(value):#x} ({np.uint32(value & 0xFFFFFFFF).view(np.float32)})"
    if name == "weight":
        return f"{int(value):#x} ({value.view(np.float64)})"
    if name == "reward":
        return f"{int(value)} ({int(value) / 2**24})"
    return str(int(value))
