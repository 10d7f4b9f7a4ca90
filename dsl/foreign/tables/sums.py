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
        self.rough: list[tuple[str, float, Span]] = []
        # Rows of one specification that sum to the same are one mistake.
        self.wrong: dict[tuple[Span, float], list[str]] = {}

    def is_probability(self, number: float) -> bool:
        """Return whether a number is one that a row may have."""
        return 0 <= number <= 1 + self.tolerance

    def check(self, row: str, total: float, place: Span) -> None:
        """Take the sum of a row, ``row`` in words."""
        off = abs(total - 1)
        if off <= self.tolerance:
            self.scaled += off > TOLERANCE
        elif off <= ROUGH:
            self.rough.append((row, total, place))
        else:
            self.wrong.setdefault((place, total), []).append(row)

    def tell(self) -> None:
        """Note the mistakes."""
        if self.rough:
            command = f"hypgen import {shlex.quote(self.trouble.source.name)} --normalise"
            row, total, place = self.rough[0]
            more = len(self.rough) - 1
            self.trouble.add(e09_other_formats.rough_sums(row, total, more, command, place))
        for (place, total), rows in list(self.wrong.items())[:_SHOWN]:
            self.trouble.add(e09_other_formats.wrong_sum(rows[0], total, len(rows) - 1, place))
        rest = list(self.wrong.items())[_SHOWN:]
        if rest:
            count = sum(len(rows) for _, rows in rest)
            self.trouble.add(e09_other_formats.more_wrong_sums(count, rest[0][0][0]))
        self.rough, self.wrong = [], {}

    def notes(self) -> list[str]:
        """Return what to tell of rows that were off by more than files round."""
        if not self.scaled:
            return []
        rows = "1 row is" if self.scaled == 1 else f"{self.scaled} rows are"
        return [f"{rows} scaled to sum to 1."]
