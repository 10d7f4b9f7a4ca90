# SPDX-License-Identifier: Apache-2.0
"""What rows of probabilities sum to: those that are only rounded are told once, with what scales them."""

from __future__ import annotations

import shlex

from hypgen.dsl.foreign.tables.rows import ROUGH, TOLERANCE
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_other_formats
from hypgen.dsl.messages.source import Span

_SHOWN = 5


class Sums:
    """The rows of a file that do not sum to 1; ``tolerance`` says by how much they may be off."""

    def __init__(self, trouble: Trouble, tolerance: float) -> None:
        self.trouble, self.tolerance = trouble, tolerance
        self.scaled = 0
        self.rough: list[tuple[str, float, Span, int]] = []
        # Rows of one specification that sum to the same are one mistake: the first, and how many there are.
        self.wrong: dict[tuple[Span, float], tuple[str, int]] = {}

    def is_probability(self, number: float) -> bool:
        """Return whether a number is one that a row may have."""
        return 0 <= number <= 1 + self.tolerance

    def check(self, row: str, total: float, place: Span, number: int = 1) -> None:
        """Take the sum of a row, ``row`` in words; ``number`` rows are like it."""
        off = abs(total - 1)
        if off <= self.tolerance:
            self.scaled += number * (off > TOLERANCE)
        elif off <= ROUGH:
            self.rough.append((row, total, place, number))
        else:
            first, before = self.wrong.get((place, total), (row, 0))
            self.wrong[place, total] = (first, before + number)

    def tell(self) -> None:
        """Note the mistakes."""
        if self.rough:
            command = f"hypgen import {shlex.quote(self.trouble.source.name)} --normalise"
            row, total, place, _ = self.rough[0]
            more = sum(number for *_, number in self.rough) - 1
            self.trouble.add(e09_other_formats.rough_sums(row, total, more, command, place))
        for (place, total), (row, number) in list(self.wrong.items())[:_SHOWN]:
            self.trouble.add(e09_other_formats.wrong_sum(row, total, number - 1, place))
        rest = list(self.wrong.items())[_SHOWN:]
        if rest:
            count = sum(number for _, (_, number) in rest)
            self.trouble.add(e09_other_formats.more_wrong_sums(count, rest[0][0][0]))
        self.rough, self.wrong = [], {}

    def notes(self) -> list[str]:
        """Return what to tell of rows that were off by more than files round."""
        if not self.scaled:
            return []
        rows = "1 row is" if self.scaled == 1 else f"{self.scaled} rows are"
        return [f"{rows} scaled to sum to 1."]
