# SPDX-License-Identifier: Apache-2.0
"""Expressions and distributions of the intermediate representation; ``ir`` has its invariants."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeVar

from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import BOOL, Enum, Record, Type

# Expressions -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Expr:
    """Base of expressions; ``type`` is never an array.

    ``span`` says where a sampled mistake in it stands, or a read of state; other expressions have none.
    """

    type: Type
    span: Span | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Const(Expr):
    """A constant: bool, int (or code), or a float that float32 holds exactly.

    ``exact`` is the number that the text says, where float32 has rounded it; probabilities read it.
    ``precise``: a probability has the mass of that number however well float32 holds it.
    """

    value: bool | int | float
    exact: Fraction | None = field(default=None, kw_only=True)
    precise: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Local(Expr):
    """A binder, a ``LetIn`` name, a function's formal or the argument that a ``match`` binds."""

    name: str


@dataclass(frozen=True)
class ParamRead(Expr):
    """An entry of a param; one index for each of its index types."""

    param: str
    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class TableRead(Expr):
    """An entry of a constant array."""

    table: str
    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class StateRead(Expr):
    """A variable's value before the step, or after it when ``primed``.

    Indices: the family member's first (if the element is a family), then the variable's own.
    """

    variable: str
    indices: tuple[Expr, ...] = ()
    primed: bool = False


@dataclass(frozen=True)
class LetRead(Expr):
    """A let's value; ``primed`` evaluates its expression with every unprimed state read primed.

    A let that draws is never primed. One index if the let's element is a family.
    """

    let: str
    indices: tuple[Expr, ...] = ()
    primed: bool = False


@dataclass(frozen=True)
class ActionRead(Expr):
    """The action, or one component of a product action (one index for each index type)."""

    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class MemoryRead(Expr):
    """A register as it is before this decision; only the policy and ``bound lower`` read it."""

    register: str
    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class LastObservation(Expr):
    """What was observed in the step before; ``first`` at the start of an episode.

    Only the policy and ``bound lower`` read it. Indices: the family member's first (if the observation's
    element is a family), then the observation's own.
    """

    observation: str
    indices: tuple[Expr, ...]
    first: Expr


@dataclass(frozen=True)
class BeliefRead(Expr):
    """The mean of ``operand``, a float, under the belief about a member of the factor ``element``; or its
    ``deviation``.

    ``index`` is the member (None: no family), ``number`` counts the model's beliefs. Under an exact posterior
    the mean is the float32 sum, from 0, of p(h) * (the operand where the member's hidden state is h) over the
    joint values h with p(h) > 0, ascending. All else is computed in double: docs/internals/beliefs.md has the
    operations. The operand reads visible state and the history as they are, and no other hidden state.
    """

    number: int
    element: str
    index: Expr | None
    operand: Expr
    deviation: bool = False


@dataclass(frozen=True)
class LastAction(Expr):
    """The action of the step before, or one component of a product action; ``first`` at the start.

    Only the policy and ``bound lower`` read it.
    """

    indices: tuple[Expr, ...]
    first: Expr


@dataclass(frozen=True)
class Call(Expr):
    """A call of a model function; ``primed`` evaluates its body with every unprimed state read primed."""

    function: str
    arguments: tuple[Expr, ...]
    primed: bool = False


@dataclass(frozen=True)
class ToFloat(Expr):
    """An int (or bool) as float32, rounded to nearest even."""

    operand: Expr


@dataclass(frozen=True)
class Unary(Expr):
    """``neg not`` and the built-ins of one argument.

    ``abs sign floor ceil round``, and of floats ``sqrt exp log log2 sin cos tan asin acos`` and
    ``normal_cdf``, the probability below a number of a standard normal one. A sine, cosine or tangent of what
    is not finite is NaN, and so is the arc of what lies beyond +-1.

    ``floor ceil round`` take a float and give an int, saturated to the node's interval.
    """

    op: str
    operand: Expr


@dataclass(frozen=True)
class Binary(Expr):
    """``add sub mul div floordiv mod pow min max hypot atan2 eq ne lt le gt ge and or``.

    ``div`` is of floats; ``floordiv`` and ``mod`` floor, of ints, and give 0 where the divisor is 0;
    ``pow``, ``hypot`` and ``atan2`` are of floats (ints to a constant power are lowered to products);
    ``min`` is ``b < a ? b : a`` and ``max`` is ``a < b ? b : a``.
    """

    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Clamp(Expr):
    """An int or float forced into [low, high], constants of the node's type."""

    operand: Expr
    low: int | float
    high: int | float


@dataclass(frozen=True)
class Checked(Clamp):
    """A ``Clamp`` that should change nothing: ``hypgen check`` reports a state in which it does."""


@dataclass(frozen=True)
class If(Expr):
    """``then`` where ``condition`` holds, else ``otherwise``; ``match`` is lowered to a chain of these."""

    condition: Expr
    then: Expr
    otherwise: Expr


@dataclass(frozen=True)
class LetIn(Expr):
    """``body`` with ``name`` standing for ``value``."""

    name: str
    value: Expr
    body: Expr


@dataclass(frozen=True)
class IsVariant(Expr):
    """Whether an enum's value is the variant (of any argument)."""

    enum: Enum
    variant: str
    operand: Expr


@dataclass(frozen=True)
class VariantArgument(Expr):
    """The argument of an enum's value, meaningful only where ``IsVariant`` holds."""

    enum: Enum
    variant: str
    operand: Expr


@dataclass(frozen=True)
class MakeVariant(Expr):
    """A variant with an argument."""

    enum: Enum
    variant: str
    argument: Expr


@dataclass(frozen=True)
class FieldRead(Expr):
    """A field of a record."""

    record: Record
    field: str
    operand: Expr


@dataclass(frozen=True)
class MakeRecord(Expr):
    """A record of its fields' values, in order."""

    record: Record
    values: tuple[Expr, ...]


@dataclass(frozen=True)
class Binder:
    """A local that takes every value of a finite type, in ascending order."""

    name: str
    type: Type


@dataclass(frozen=True)
class Quantified(Expr):
    """``sum any all count min max argmin argmax`` over all values of the binders where ``condition`` holds.

    Evaluated in lexicographic order, the first binder outermost; ``sum`` starts from 0 and adds in that
    order; the first of equal values wins in ``argmin`` and ``argmax`` (one binder, whose value it
    gives). ``body`` is None for ``count`` only. ``otherwise`` is the value where nothing matched, for
    ``min max argmin argmax``; without it (provably never empty, or a model error) the body or binder
    at its first values stands in.
    """

    kind: str
    binders: tuple[Binder, ...]
    condition: Expr | None
    body: Expr | None
    otherwise: Expr | None


# Distributions -----------------------------------------------------------------------------------
#
# Each is sampled by inverse CDF from one 32-bit word w or, where probabilities count, from the 63 bits
# W = w * 2^31 + (v >> 1), where v is a second word of the same draw. As W is only compared, v is made only
# where w ties. M(p) = trunc(double(p) * 2^63) clamped to [0, 2^63] is the mass of a probability p (NaN gives
# 0). It is a whole number of words, 2^31 each, for each float32 from 2^-9 up. Beside p may stand its
# complement q, an expression for 1 - p: if q < 2^-9, the mass is 2^63 - M(q). A constant's mass is that of
# its exact number where float32 does not hold it well (``masses.of_constant``).


@dataclass(frozen=True)
class Dist:
    """Base of distributions over scalars of ``type``; ``span`` is where one is written."""

    type: Type
    span: Span | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Certain(Dist):
    """A value with probability 1; takes no word."""

    value: Expr


@dataclass(frozen=True)
class Bernoulli(Dist):
    """true where W < M(p). Density: M(p) / 2^63, or what is left."""

    probability: Expr
    complement: Expr | None = None


@dataclass(frozen=True)
class Uniform(Dist):
    """Every value of the finite ``type``: low + ((w * n) >> 32). Density: 1 / n."""


@dataclass(frozen=True)
class UniformSet(Dist):
    """``value`` at a uniformly chosen match of ``binders where condition``.

    With c matches the one numbered (w * c) >> 32 in order is taken; ``otherwise`` is drawn, from the same
    word, where c is 0 (without it, the value at the binders' first values). Density: the share of matches
    whose value is equal, double(count) / double(c).
    """

    binders: tuple[Binder, ...]
    condition: Expr | None
    value: Expr
    otherwise: Dist | None


@dataclass(frozen=True)
class Table(Dist):
    """Values with weights; ``rest`` (or the last entry, if None) takes what is left.

    With m_i = M(p_i), entry i is the first with W < m_0 + ... + m_i, where sums end at 2^63. Without
    ``rest``, where the last m_i is below 2^54 (a probability of 2^-9), the likeliest entry (the first with
    the largest m_i) is given what the other masses leave of 2^63. Where all p_i are constants,
    ``masses.of_table`` has the masses. ``complements`` is empty or has the complement of each p_i that has
    one. Density of v: the masses that give it, over 2^63.
    """

    entries: tuple[tuple[Expr, Expr], ...]
    rest: Expr | None
    complements: tuple[Expr | None, ...] = ()


@dataclass(frozen=True)
class Noisy(Dist):
    """``value`` with probability p, else uniformly one of the n - 1 others.

    With t = M(p) and r = 2^63 - t: ``value`` if W < t; otherwise one of the others, counted in ascending
    order and passing over ``value``. If t = 2^31 * t' and r >= (n - 1) * 2^45, it is the one numbered
    ((w - t') * (n - 1)) / (2^32 - t'). If not, the others get equal parts of r, in order, of which the first
    r mod (n - 1) are larger by 1. If n is 1, ``value``. Density: t / 2^63, or (r / 2^63) / (n - 1); 1 if n
    is 1.
    """

    value: Expr
    probability: Expr
    complement: Expr | None = None


@dataclass(frozen=True)
class IfDist(Dist):
    """One of two distributions, drawn from the same word."""

    condition: Expr
    then: Dist
    otherwise: Dist


@dataclass(frozen=True)
class LetDist(Dist):
    """``body`` with ``name`` standing for ``value``."""

    name: str
    value: Expr
    body: Dist


@dataclass(frozen=True)
class DrawIn(Dist):
    """``body`` with ``name`` standing for what ``law`` draws, which is no float.

    ``law`` takes the first words of the draw, ``body`` those behind them (``draw_words.words_of``): word n of
    entry i is that of the site at index i + n * 2^24. Density of v: the sum, from 0, over the values x of
    ``law``'s type, ascending, whose density p is above 0, of p * (density of v under ``body``, where ``name``
    is x).
    """

    name: str
    law: Dist
    body: Dist


@dataclass(frozen=True)
class InVariant(Dist):
    """The variant of an enum, ``type``, whose argument ``dist`` draws. Density: 0 of other variants."""

    type: Enum
    variant: str
    dist: Dist

    def made_of(self, argument: Expr) -> Expr:
        """Return the value that is drawn with an argument."""
        return MakeVariant(self.type, self.type, self.variant, argument)

    def is_made(self, value: Expr) -> Expr:
        """Return whether a value of the enum can be drawn."""
        return IsVariant(BOOL, self.type, self.variant, value)

    def argument_of(self, value: Expr) -> Expr:
        """Return the argument with which a value is drawn."""
        return VariantArgument(self.dist.type, self.type, self.variant, value)


Placed = TypeVar("Placed", Expr, Dist)


def placed(node: Placed, span: Span) -> Placed:
    """Return ``node`` with its place in the text, unless it has one."""
    return node if node.span is not None else replace(node, span=span)
