# SPDX-License-Identifier: Apache-2.0
"""Pairs of floats on which functions of one or two arguments may go wrong."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

EDGES = [
    *(0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0, 1e-45, -1e-45, 1e-38, 1.1754944e-38),
    *(3.4028235e38, -3.4028235e38, math.inf, -math.inf, math.nan, 88.72283, 88.72284, -103.97, -103.98),
    *(128.0, 127.99999, -149.0, -149.5, -150.0, 0.99999994, 1.0000001, 1.4142135, 1.4142137, 0.70710677),
    *(2147483648.0, -2147483648.0, 16777216.0, 4294967296.0, 1000.5, -100.5, 2.5, -2.5, 1e30),
    *(0.7853982, 1.5707964, 3.1415927, 1048576.0, 1048576.1, 16367173.0, 6.0e37, 37.2, -37.3, 1e-39),
]


def float_pairs(count: int, seed: int) -> npt.NDArray[np.float32]:
    """Every edge with every edge, all bit patterns, and the magnitudes that models use."""
    random = np.random.default_rng(seed)
    patterns = random.integers(0, 2**32, (count // 2, 2), dtype=np.uint32).view(np.float32)
    usual = (random.normal(0, 1, (count // 2, 2)) * 10.0 ** random.uniform(-4, 2, (count // 2, 2))).astype(
        "f4"
    )
    small_powers = usual.copy()
    small_powers[:, 1] = np.rint(small_powers[:, 1])
    edges = np.array([(a, b) for a in EDGES for b in EDGES], dtype=np.float32)
    return np.concatenate([edges, patterns, usual, small_powers])
