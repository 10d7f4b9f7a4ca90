# SPDX-License-Identifier: Apache-2.0
"""Places of the digits of an observation key.

A key whose values are at most 2^64 in number is one word, the first digit the most significant. A longer one
is several words, filled in order: a digit that no longer fits into its word starts the next, and within a
word the first digit is the least significant, so that reader and writer walk the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.dsl import ir

WORD = 2**64  # values of a word


@dataclass(frozen=True)
class Digit:
    """An entry of a key field: ``(key[word] // place) % size`` of a key."""

    field: ir.KeyField
    entry: int  # row-major, in the field
    size: int
    word: int
    place: int


def is_wide(key: tuple[ir.KeyField, ...]) -> bool:
    """Return whether the key takes more than one word."""
    return _product(key) > WORD


def word_count(key: tuple[ir.KeyField, ...], most: int | None = None) -> int:
    """Return the number of words; with ``most``, stop counting beyond that many."""
    words, values = 1, 1
    if not is_wide(key):
        return words
    for field in key:
        size = field.size
        for _ in range(field.length if size > 1 else 0):
            if values * size > WORD:
                words, values = words + 1, 1
                if most is not None and words > most:
                    return words
            values *= size
    return words


def digits(key: tuple[ir.KeyField, ...]) -> tuple[Digit, ...]:
    """Return all digits in order."""
    result: list[Digit] = []
    wide = is_wide(key)
    word, values = 0, 1 if wide else _product(key)
    for field in key:
        size = field.size
        for entry in range(field.length):
            if wide:
                if values * size > WORD:
                    word, values = word + 1, 1
                result.append(Digit(field, entry, size, word, values % WORD))
                values *= size
            else:
                values //= size
                result.append(Digit(field, entry, size, word, values))
    return tuple(result)


def _product(key: tuple[ir.KeyField, ...]) -> int:
    """Return the number of keys, or some number above 2^64 where there are more."""
    product = 1
    for field in key:
        size = field.size
        product *= size ** min(field.length, 65) if size > 1 else 1
    return product
