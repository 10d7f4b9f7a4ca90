# SPDX-License-Identifier: Apache-2.0
"""Numbers as text: those of which float32 is kept, and probabilities, of which all digits count."""

from __future__ import annotations

import math
import struct
from functools import lru_cache

_NORMAL = 2.0**-126  # float32s below have fewer digits


@lru_cache(maxsize=1 << 17)
def shown(number: float) -> str:
    """Return the shortest text that gives the same float32; a number too large for one is given in full."""
    try:
        kept = _float32(number)
    except OverflowError:
        return repr(number)
    text = _shortest(kept)
    if "e" in text and 1e-4 <= abs(number) < 1e9:
        text = f"{float(text):.10f}".rstrip("0").rstrip(".")
    return _brief(text)


def in_full(number: float) -> str:
    """Return a number with 15 digits at most, which is what a file's double tells."""
    return _brief(f"{number:.15g}")


def _brief(text: str) -> str:
    return text.replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def _shortest(kept: float) -> str:
    if abs(kept) < _NORMAL or abs(math.frexp(kept)[0]) == 0.5:  # neighbours are nearer on one side
        return next(t for d in range(1, 10) if _gives(t := f"{kept:.{d}g}", kept))
    text = f"{kept:.7g}"
    if not _gives(text, kept):
        return text if _gives(text := f"{kept:.8g}", kept) else f"{kept:.9g}"
    # Texts of up to six digits are different float32s: one of seven at most has a shorter one.
    shorter = f"{kept:.6g}"
    return shorter if shorter != text and _gives(shorter, kept) else text


def _gives(text: str, kept: float) -> bool:
    number = float(text)
    return abs(number - kept) <= 2.0**-24 * abs(kept) + 2.0**-150 and _float32(number) == kept


def _float32(number: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", number))[0])
