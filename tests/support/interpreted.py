# SPDX-License-Identifier: Apache-2.0
"""Expressions by themselves, evaluated by the interpreter inside a model that has nothing but a name."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Frame
from hypgen.dsl.types import Bool, Float
from support import ir_samples


def evaluator(**changes: Any) -> Evaluator:
    model = dataclasses.replace(ir_samples.tiger(), **changes)
    return Evaluator(model, {})


def value(e: ir.Expr, v: Any = 0, within: Evaluator | None = None) -> list[Any]:
    """Return what ``e`` is in each lane, the local ``v`` having one of the given values in each."""
    lanes = np.asarray([v] if np.ndim(v) == 0 else v)
    lanes = lanes.astype(
        np.float32 if lanes.dtype.kind == "f" else lanes.dtype if lanes.dtype == bool else np.int32
    )
    frame = Frame(np.arange(len(lanes)), {}, locals={"v": lanes})
    result = (within or evaluator()).value(e, frame)
    kind = {Bool: "b", Float: "f"}.get(type(e.type), "i")
    assert result.dtype.kind == kind and result.dtype.itemsize in (1, 4)
    return list(np.broadcast_to(result, lanes.shape).tolist())
