# SPDX-License-Identifier: Apache-2.0
"""Random words as a function of names: Philox4x32-10, many lanes at once.

Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC 2011). Words are held
in uint64 arrays, so that the 32 x 32 bit products are exact.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Words = npt.NDArray[np.uint64]

_MASK = np.uint64(0xFFFFFFFF)
_SHIFT = np.uint64(32)
_MULTIPLIERS = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_WEYL = 0x9E3779B9, 0xBB67AE85
_ROUNDS = 10
_DERIVE_TAG = 0x68797067


class Stream(IntEnum):
    """What a stream of random words is for; each kind has keys of its own."""

    WORLD = 0
    BELIEF = 1
    PLAN = 2
    TEST = 3


def philox(key: tuple[int, int], counter: tuple[Any, Any, Any, Any]) -> tuple[Words, Words, Words, Words]:
    """Return the four output words of each lane; the counter's words are ints or arrays that broadcast."""
    c0, c1, c2, c3 = (np.asarray(word, dtype=np.uint64) for word in counter)
    for i in range(_ROUNDS):
        k0, k1 = (np.uint64((key[j] + i * _WEYL[j]) & 0xFFFFFFFF) for j in range(2))
        product0, product1 = c0 * _MULTIPLIERS[0], c2 * _MULTIPLIERS[1]
        c0, c1, c2, c3 = (
            (product1 >> _SHIFT) ^ c1 ^ k0,
            product1 & _MASK,
            (product0 >> _SHIFT) ^ c3 ^ k1,
            product0 & _MASK,
        )
    return c0, c1, c2, c3


def derive(seed: int, kind: int, number: int) -> tuple[int, int]:
    """Return the key of stream ``number`` of a kind."""
    counter = (kind, number & 0xFFFFFFFF, (number >> 32) & 0xFFFFFFFF, _DERIVE_TAG)
    word0, word1, _, _ = philox((seed & 0xFFFFFFFF, (seed >> 32) & 0xFFFFFFFF), counter)
    return int(word0), int(word1)


class DrawSource(Protocol):
    """Where draws get their words: random, recorded or enumerated."""

    def word(self, site: int, index: int | npt.NDArray[np.int64]) -> Words:
        """Return each lane's 32-bit word of a draw; an array of indexes has one for each lane."""
        ...


class PhiloxDraws:
    """Words keyed by (key; scenario, step, site, index); blocks of four are kept while the source lives."""

    def __init__(self, key: tuple[int, int], scenario: npt.ArrayLike, step: npt.ArrayLike) -> None:
        self._key = key
        self._scenario = np.asarray(scenario, dtype=np.uint64)
        self._step = np.asarray(step, dtype=np.uint64)
        self._blocks: dict[tuple[int, int], tuple[Words, Words, Words, Words]] = {}

    def word(self, site: int, index: int | npt.NDArray[np.int64]) -> Words:
        """Return each lane's 32-bit word of a draw; an array of indexes has one for each lane."""
        if isinstance(index, np.ndarray):
            block = philox(self._key, (self._scenario, self._step, site, index >> 2))
            return np.choose(index & 3, block)
        place = (site, index >> 2)
        if place not in self._blocks:
            self._blocks[place] = philox(self._key, (self._scenario, self._step, *place))
        return self._blocks[place][index & 3]
