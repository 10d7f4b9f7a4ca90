# SPDX-License-Identifier: Apache-2.0
"""Rows of probabilities: what they may sum to, and their sparse form."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hypgen.dsl.foreign.tables.foreign_model import Row

# Files print 1/3 with a few digits; a row is off by that for each of its entries.
TOLERANCE = 1.01e-4
# What `--normalise` scales unless told otherwise: beyond, a row is wrong and not rounded.
ROUGH = 0.01
# A table's last entry is written as what the others leave. Next to one below this, that is the likeliest.
_RARE = 2.0**-9
# The language takes a row that is off by as much as it is.
_EXACT = 2e-6


def row_of(values: Sequence[float]) -> Row:
    """Return the row of probabilities given for every value."""
    return normalised(enumerate(values))


def normalised(entries: Iterable[tuple[int, float]]) -> Row:
    """Return what is above 0, by value, scaled where it is visibly off 1."""
    kept = sorted((v, p) for v, p in entries if p > 0)
    total = sum(p for _, p in kept)
    if abs(total - 1) <= _EXACT or not kept:
        return tuple(kept)
    return tuple((v, p / total) for v, p in kept)


def in_order(row: Row) -> Row:
    """Return a row as it is written: its likeliest entry last, where another's probability is small."""
    if min(p for _, p in row) >= _RARE:
        return row
    likeliest = max(row, key=lambda entry: entry[1])
    return (*(entry for entry in row if entry is not likeliest), likeliest)
