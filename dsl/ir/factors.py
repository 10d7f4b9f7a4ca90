# SPDX-License-Identifier: Apache-2.0
"""Factors: hidden variables that are independent, a part of the intermediate representation."""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.dsl.ir.nodes import BeliefRead, Binder, Expr, StateRead, ToFloat
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Bool, size_of


@dataclass(frozen=True)
class Evidence:
    """What the agent learns in a step, and of which member of a factor it tells.

    ``kind``: ``visible`` (the new value of the visible variable ``name``, by its density), ``observe`` (an
    observation), ``end`` (that the episode goes on: ``condition`` is false); at the start ``first`` (the
    value of the informative variable ``name``); one for each value of ``binders``.
    ``touch`` is the position, from 0, of the member whose hidden state it reads, -1 for none.
    """

    kind: str
    name: str
    binders: tuple[Binder, ...]
    touch: Expr
    condition: Expr | None = None


@dataclass(frozen=True)
class Moments:
    """How the belief about ``variable``, the one scalar of a factor and a float, is kept by two numbers.

    Mean and deviation are those of a normal law; of the beta law of the range between ``ends`` where the
    variable never leaves it. ``still``: no step changes it. docs/internals/beliefs.md has the operations.
    """

    variable: str
    still: bool
    ends: tuple[Expr, Expr] | None


@dataclass(frozen=True)
class Factor:
    """The hidden variables of an element, or of each member of a family: independent of all others given
    what the agent has seen. ``evidence`` is in the order in which it is weighed; ``first`` is that of the
    start.

    One factor may be ``joined``: the hidden variables of all elements that are none by themselves. It has no
    binder even where these are families, and ``element`` is a name for all of them.

    ``size`` is the number of joint values, coded in mixed radix: ``variables`` in order, entries row-major,
    the first the most significant; 0 where no exact posterior is kept, and then ``inexact`` says why. Of a
    float a policy may know its ``moments``; ``unmatched`` says why not.
    """

    element: str
    binder: Binder | None
    variables: tuple[str, ...]
    size: int
    inexact: str
    evidence: tuple[Evidence, ...]
    first: tuple[Evidence, ...] = ()
    moments: Moments | None = None
    unmatched: str = ""
    joined: bool = False

    @property
    def exact(self) -> bool:
        """Return whether the factor's posterior is kept exactly, as a number for each joint value."""
        return self.size > 0

    def holds(self, read: BeliefRead) -> bool:
        """Return whether ``read`` is a number that is kept: a single bool's probability, or a moment."""
        if self.element == read.element and self.moments is not None:
            return isinstance(read.operand, StateRead)
        operand = read.operand.operand if isinstance(read.operand, ToFloat) else None
        return (
            self.element == read.element
            and self.size == 2
            and not read.deviation
            and isinstance(operand, StateRead)
            and isinstance(operand.type, Bool)
        )

    @property
    def members(self) -> int:
        """Return how many factors of the kind there are: one for each member."""
        return 1 if self.binder is None else size_of(self.binder.type)


@dataclass(frozen=True)
class Obstacle:
    """Why the hidden variables of an element are no factor: the place that reads, and the reason."""

    element: str
    span: Span
    reason: str
