# SPDX-License-Identifier: Apache-2.0
"""Owners: the declarations whose expressions read something."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

OwnerKind = Literal[
    "init",
    "update",
    "observe",
    "let",
    "function",
    "reward",
    "invariant",
    "bound",
    "draw",
    "terminal",
    "legal",
    "success",
    "policy",
    "policy let",
    "first memory",
    "next memory",
    "belief",
]

_TEXTS = {
    "function": "fn {name}",
    "terminal": "terminal when",
    "legal": "legal when",
    "success": "success when",
    "policy": "policy default",
    "policy let": "let {name}",
    "first memory": "memory {name}",
    "next memory": "memory {name}'",
    "belief": "belief {name} of {asker}",
}


@dataclass(frozen=True)
class Owner:
    """The declaration that an expression belongs to.

    ``name`` is that of the variable, observation, function ...; empty where a model has one of the kind.
    A ``belief(..)`` owns the expression in its parentheses. Its ``name`` is its number. Its ``asker`` owns
    the expression that it stands in.
    """

    kind: OwnerKind
    name: str = ""
    asker: Owner | None = None

    def __str__(self) -> str:
        """Return the owner as messages name it: ``init rover.x``, ``terminal when``."""
        return _TEXTS.get(self.kind, "{kind} {name}").format(**vars(self))
