# SPDX-License-Identifier: Apache-2.0
"""Names of a foreign file as names of this language."""

from __future__ import annotations

import re
from collections.abc import Iterable

_WORDS = """
model instance library of import const param type enum record fn action element observe reward
policy bound invariant draw init let memory choose discount horizon terminal legal success when if then
else match in where is with visible hidden fixed bool prob int float true false and or not gamma pi abs acos
asin at atan2 belief bernoulli binned binomial cdf ceil checked clamp cos count deviation distance exp
exponential floor hypot index last log log2 max min noisy normal poisson round sign sin sqrt sum any
all argmin argmax tan truncated uniform value weighted wrap default upper lower tail
"""
_RESERVED = frozenset(_WORDS.split())


class Names:
    """Hands out names that are legal and taken once."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self.taken = set(_RESERVED) | set(taken)

    def unique(self, wanted: str, otherwise: str) -> str:
        """Return a name as near to ``wanted`` as can be; ``otherwise`` starts one that has no letter."""
        name = re.sub(r"\W", "_", wanted, flags=re.ASCII)
        if not re.search(r"[A-Za-z]", name) or not re.match(r"[A-Za-z_]", name):
            name = f"{otherwise}_{name.strip('_')}".rstrip("_")
        base, number = name, 2
        while name in self.taken:
            name, number = f"{base}_{number}", number + 1
        self.taken.add(name)
        return name


def type_name(variable: str) -> str:
    """Return what the type of a variable is called: ``rover_0`` gives ``Rover0``."""
    words = re.findall(r"[A-Za-z0-9]+", variable)
    return "".join(word[0].upper() + word[1:] for word in words) or "Value"


def model_name(stem: str) -> str:
    """Return a model's name from its file's: ``tiger.95`` gives ``Tiger95``."""
    name = type_name(stem)
    return name if name[0].isalpha() else f"Model{name}"


def is_plain(original: str, name: str) -> bool:
    """Return whether a name differs from the file's only by ``_`` where that has signs between letters."""
    return re.sub(r"[^A-Za-z0-9]", "_", original) == name
