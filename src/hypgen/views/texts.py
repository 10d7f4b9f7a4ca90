# SPDX-License-Identifier: Apache-2.0
"""Numbers as the page shows them; ``values.js`` has the same rule."""

from __future__ import annotations

import math


def number(value: float | None) -> str:
    """Return a number with four significant digits, and with all before the point."""
    if value is None or not math.isfinite(value):
        return "unknown"
    return str(round(value)) if 1000 <= abs(value) < 1e9 else f"{value + 0.0:.4g}"
