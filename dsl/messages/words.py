# SPDX-License-Identifier: Apache-2.0
"""Words that many messages share: a type, a stretch of numbers, how many of something."""

from __future__ import annotations

from dataclasses import replace

from hypgen.dsl.types import Float, Int, Type


def described(t: Type) -> str:
    """Return a type in words, an int's interval left out."""
    if isinstance(t, Float):
        return f"a {replace(t, prob=False)}"
    return "an int" if isinstance(t, Int) else f"of type {t}"


def lies(low: float, high: float) -> str:
    """Return where a value lies, in words."""
    ends = [f"{x:g}" if isinstance(x, float) else str(x) for x in (low, high)]
    return f"is {ends[0]}" if low == high else f"ranges over {' .. '.join(ends)}"


def counted(number: int, noun: str) -> str:
    """Return ``1 argument`` or ``2 arguments``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def given(number: int) -> str:
    """Return ``1 is given`` or ``2 are given``."""
    return f"{number} {'is' if number == 1 else 'are'} given"
