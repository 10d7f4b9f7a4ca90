# SPDX-License-Identifier: Apache-2.0
"""Units of measurement: what they are made of, and what arithmetic makes of them.

A unit is a sorted tuple of names with exponents other than 0; the empty one is that of a plain number. None
stands for the unit of a literal, which takes whatever unit its surroundings ask for.
"""

from __future__ import annotations

import re

Unit = tuple[tuple[str, int], ...]
PLAIN: Unit = ()

_FACTOR = re.compile(r"([*/]?)([A-Za-z_]\w*)(?:\^(\d+))?")


def parse(text: str) -> Unit:
    """Return what is written between ``<`` and ``>``: ``m/s^2``, ``m*kg``, ``1/s``, ``1``."""
    result: Unit = PLAIN
    for sign, name, exponent in _FACTOR.findall(text):
        factor = power(((name, 1),), int(exponent or 1))
        result = product(result, factor, -1 if sign == "/" else 1) or PLAIN
    return result


def shown(unit: Unit | None) -> str:
    """Return a unit as an author writes it; nothing for a plain number."""
    over = [_factor(name, n) for name, n in unit or () if n > 0]
    under = [_factor(name, -n) for name, n in unit or () if n < 0]
    return "/".join(["*".join(over) or "1", *under]) if unit else ""


def _factor(name: str, exponent: int) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"


def described(unit: Unit | None) -> str:
    """Return a float of this unit in words."""
    return f"float<{shown(unit)}>" if unit else "a number without a unit"


def merged(a: Unit | None, b: Unit | None) -> Unit | None:
    """Return the unit that two values share: that of the one that has one."""
    return b if a is None else a


def agree(a: Unit | None, b: Unit | None) -> bool:
    """Return whether values of two units may be added, compared or assigned."""
    return a is None or b is None or a == b


def product(a: Unit | None, b: Unit | None, sign: int = 1) -> Unit | None:
    """Return the unit of a * b, or of a / b where ``sign`` is -1."""
    if a is None and b is None:
        return None
    exponents = dict(a or ())
    for name, n in b or ():
        exponents[name] = exponents.get(name, 0) + sign * n
    return tuple(sorted((name, n) for name, n in exponents.items() if n))


def power(unit: Unit | None, exponent: int) -> Unit | None:
    """Return the unit of a value raised to an integer power."""
    return None if unit is None else tuple((name, n * exponent) for name, n in unit if exponent)


def root(unit: Unit | None) -> Unit | None:
    """Return the unit of a square root; ``has_root`` says whether there is one."""
    return None if unit is None else tuple((name, n // 2) for name, n in unit)


def has_root(unit: Unit | None) -> bool:
    """Return whether every exponent is even."""
    return all(n % 2 == 0 for _, n in unit or ())
