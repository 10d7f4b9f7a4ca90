# SPDX-License-Identifier: Apache-2.0
"""The random word of a draw in C++."""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.codegen.tree.expr import Expr, Literal, call, method, number, plus


@dataclass(frozen=True)
class Word:
    """The word of a draw as C++: ``plain`` of 32 bits, ``fine`` with the 31 bits below it."""

    site: Expr
    index: Expr

    @staticmethod
    def of(site: str, index: Expr) -> Word:
        """Return the word that a site of the model draws."""
        return Word(Literal(f"Site::{site}"), index)

    @property
    def plain(self) -> Expr:
        """Return the word of 32 bits."""
        return method("draws", "word", self.site, self.index)

    @property
    def fine(self) -> Expr:
        """Return the word with the 31 bits below it."""
        return call("dist::fine", "draws", self.site, self.index)

    def to(self, is_plain: bool) -> Expr:
        """Return one of both."""
        return self.plain if is_plain else self.fine

    def behind(self, words: int) -> Word:
        """Return the word that lies so many behind this one, for a draw within the draw."""
        step: Expr = Literal("dist::kNextDraw")
        if words != 1:
            step = number(words) * step
        return Word(self.site, plus(self.index, step)) if words else self
