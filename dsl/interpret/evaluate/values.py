# SPDX-License-Identifier: Apache-2.0
"""Values of the interpreter: one array entry a lane, or a scalar where all lanes agree.

bool_ for ``bool``, float32 for floats, int32 for everything else. Arrays broadcast: an expression that
depends on the action alone has the action's shape, so that legality of all actions is one evaluation.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from hypgen.dsl.interpret.floats.philox import DrawSource, Words
from hypgen.dsl.interpret.floats.scalar_functions import canonical_bits
from hypgen.dsl.ir import Binder
from hypgen.dsl.types import Bool, Float, Type, low_of, size_of

Array = npt.NDArray[Any]
State = dict[str, Array]
History = dict[str, Array]
_SECOND = 1 << 31  # in the index of a draw's second word
_NEXT = 1 << 24  # from the index of a draw to that of one within it
_LOW_BITS = np.uint64(31)
_LOW = np.uint64(2**31 - 1)


@dataclass(frozen=True)
class Word:
    """The word of a draw, which a certain value never asks for, and the 31 bits below it."""

    draws: DrawSource
    site: int
    index: int | Array

    def first(self) -> Words:
        """Return the 32-bit word in each lane."""
        return self.draws.word(self.site, self.index)

    def second(self) -> Words:
        """Return the word whose upper 31 bits stand below the first."""
        return self.draws.word(self.site, self.index | _SECOND)

    def behind(self, words: int) -> Word:
        """Return the word that lies so many behind this one, for a draw within the draw."""
        return replace(self, index=self.index + words * _NEXT) if words else self

    def __call__(self) -> Words:
        """Return the 32-bit word in each lane."""
        return self.first()

    def below(self, mass: Array) -> Array:
        """Return whether the draw's 63 bits are below ``mass``; makes the second word where that decides."""
        word, high, low = self.first(), mass >> _LOW_BITS, mass & _LOW
        ties = (word == high) & (low > 0)
        if not ties.any():
            return np.asarray(word < high)
        return np.asarray((word < high) | (ties & (self.second() >> np.uint64(1) < low)))

    def whole(self) -> Words:
        """Return all 63 bits."""
        return (self.first() << _LOW_BITS) | (self.second() >> np.uint64(1))


@dataclass(frozen=True)
class Frame:
    """What an expression is evaluated in.

    Every array of a state has the lanes first, then the variable's indices. ``primed`` redirects unprimed
    reads of state to ``after``: inside a primed call. ``history`` has what ``eval_history`` says. ``decided``
    keeps the policy's lets, whose values hold for the whole decision.
    """

    lanes: Array
    state: State
    after: State | None = None
    action: Array | None = None
    draws: DrawSource | None = None
    locals: Mapping[str, Array] = field(default_factory=dict)
    primed: bool = False
    history: History | None = None
    decided: dict[str, Array] = field(default_factory=dict)

    def bind(self, values: Mapping[str, Array]) -> Frame:
        """Return the frame with more locals."""
        return replace(self, locals={**self.locals, **values})

    def enter(self, values: Mapping[str, Array], primed: bool) -> Frame:
        """Return the frame of a function's or let's body, which sees no locals but its own."""
        return replace(self, locals=values, primed=self.primed or primed)

    def word(self, site: int, index: int | Array) -> Word:
        """Return how to get the word of a draw, which a certain value never asks for."""
        draws = self.draws
        assert draws is not None, "this part of a model does not draw"
        return Word(draws, site, index)


def dtype_of(t: Type) -> npt.DTypeLike:
    """Return the array type that holds values of ``t``."""
    match t:
        case Bool():
            return np.bool_
        case Float():
            return np.float32
    return np.int32


def as_type(value: Any, t: Type) -> Array:
    """Return the value in the array type of ``t``."""
    return np.asarray(value).astype(dtype_of(t), copy=False)


def to_position(value: Array, t: Type) -> Array:
    """Return where a value stands in its finite type, from 0; lanes that hold garbage are clipped."""
    position = np.asarray(value).astype(np.int64) - low_of(t)
    return np.minimum(np.maximum(position, 0), size_of(t) - 1)


def from_position(position: Array, t: Type) -> Array:
    """Return the value at a position of a finite type."""
    return as_type(position + low_of(t), t)


def to_digit(value: Array, t: Type) -> Array:
    """Return a value's digit in the observation key: a position, or a float's bits."""
    return canonical_bits(value) if isinstance(t, Float) else to_position(value, t)


def from_digit(digit: Array, t: Type) -> Array:
    """Return the value whose digit this is."""
    if isinstance(t, Float):
        return np.asarray(digit).astype(np.uint32).view(np.float32)
    return from_position(digit, t)


def combinations(binders: tuple[Binder, ...]) -> Iterator[tuple[int, tuple[int, ...], dict[str, Array]]]:
    """Yield, in lexicographic order, a number from 0, the positions and the locals of all binders' values."""
    places = itertools.product(*(range(size_of(b.type)) for b in binders))
    for number, place in enumerate(places):
        codes = zip(binders, np.asarray(place, np.int64), strict=True)
        values = {b.name: from_position(np.asarray(code), b.type) for b, code in codes}
        yield number, place, values
