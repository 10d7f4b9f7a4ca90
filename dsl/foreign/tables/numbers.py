# SPDX-License-Identifier: Apache-2.0
"""Numbers as text: the fewest digits that give the same float32, which is all that the language keeps."""

from __future__ import annotations

import struct
from functools import lru_cache


@lru_cache(maxsize=65536)
def shown(number: float) -> str:
    """Return a number's shortest text; one too large for a float32 is given in full."""
    try:
        kept = _float32(number)
    except OverflowError:
        return repr(number)
    text = next(t for d in range(1, 10) if _float32(float(t := f"{kept:.{d}g}")) == kept)
    if "e" in text and 1e-4 <= abs(number) < 1e9:
        text = f"{float(text):.10f}".rstrip("0").rstrip(".")
    return text.replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def _float32(number: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", number))[0])
