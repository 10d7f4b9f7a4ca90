# SPDX-License-Identifier: Apache-2.0
"""From float32 to float64 and back, without warnings: what the modules of float functions share."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def quiet() -> np.errstate:
    """Return a context without floating-point warnings: lanes compute branches that are not theirs."""
    return np.errstate(all="ignore")


def double(x: npt.ArrayLike) -> Array:
    """Return float32 values as float64."""
    with quiet():
        return np.asarray(x, dtype=np.float32).astype(np.float64)


def single(x: Array) -> Array:
    """Return float64 values rounded to float32."""
    with quiet():
        return np.asarray(x).astype(np.float32)
