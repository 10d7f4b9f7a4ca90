# SPDX-License-Identifier: Apache-2.0
"""The colours that models draw with: names, and what they are on light and on dark ground.

Those with a hue are of Okabe and Ito, "Color universal design" (2008), which colour-blind readers tell apart.
"""

from __future__ import annotations

from hypgen.dsl.types.model_types import Enum, Variant

PALETTE: dict[str, tuple[str, str]] = {
    "blue": ("#0072b2", "#4aa3df"),
    "orange": ("#e69f00", "#f0b432"),
    "green": ("#009e73", "#2fc598"),
    "red": ("#d55e00", "#f08040"),
    "purple": ("#cc79a7", "#dd9abf"),
    "yellow": ("#d9c900", "#f0e442"),
    "sky": ("#56b4e9", "#86cbf2"),
    "black": ("#1f1f1f", "#e8e8e8"),
    "white": ("#ffffff", "#161616"),
    "grey": ("#9a9a9a", "#7d7d7d"),
    "brown": ("#8b5a2b", "#bd8b5e"),
}
"""Each colour as ``#rrggbb``, on light and on dark ground. Black and white are ink and ground of both."""

COLOUR = Enum("colour", tuple(Variant(name) for name in PALETTE))
"""The type of what is drawn in a colour; the codes are the places in ``PALETTE``."""
