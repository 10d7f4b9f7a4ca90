# SPDX-License-Identifier: Apache-2.0
"""Statements and functions of C++ as a tree.

A block under construction grows, and passes give new blocks; what stands in a block is shared, so no pass
changes it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from hypgen.codegen.tree.expr import Braces, Expr, Name, Operand, Prefix, of, op


class Statement:
    """A statement."""

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the expressions that stand in it, outside of its blocks."""
        return ()

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Return the blocks in it."""
        return ()

    @property
    def names(self) -> Iterator[str]:
        """Yield the names that its own expressions have."""
        for expr in self.expressions:
            yield from expr.names


Block = list[Statement]


@dataclass
class Declare(Statement):
    """A local: ``const type name = value;``, an array with dimensions, or ``type name(arguments);``."""

    type: str
    name: str
    value: Expr | None = None
    dimensions: tuple[int | str, ...] = ()  # a str where the value tells
    arguments: tuple[Expr, ...] = ()
    unused: bool = False  # whether it may be: no compiler warns then

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the value or the constructor's arguments."""
        return (*(() if self.value is None else (self.value,)), *self.arguments)


@dataclass
class Assign(Statement):
    """``target = value;``, or with another operator that assigns."""

    target: Expr
    sign: str
    value: Expr

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the target and the value."""
        return (self.target, self.value)


@dataclass
class Do(Statement):
    """An expression that is evaluated for its effect."""

    expr: Expr

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the expression."""
        return (self.expr,)


@dataclass
class Return(Statement):
    """``return value;``."""

    value: Expr

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the value."""
        return (self.value,)


@dataclass
class Jump(Statement):
    """``break;`` or ``continue;``."""

    word: str


@dataclass
class Comment(Statement):
    """A line of comment."""

    text: str


@dataclass
class Text(Statement):
    """Lines of C++ that no pass reads: entries of large constant arrays."""

    lines: tuple[str, ...]


@dataclass
class If(Statement):
    """``if``, each further branch an ``else if``, and ``else``."""

    branches: list[tuple[Expr, Block]]
    otherwise: Block = field(default_factory=list)
    short: bool = False  # without braces, if it is one line

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the conditions."""
        return tuple(condition for condition, _ in self.branches)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Return the blocks of all branches."""
        return (*(block for _, block in self.branches), self.otherwise)


@dataclass
class For(Statement):
    """``for (type variable = first; test; step)``."""

    type: str
    variable: str
    first: Expr
    test: Expr
    step: Statement
    body: Block = field(default_factory=list)
    short: bool = False

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the expressions of the head."""
        return (self.first, self.test, *self.step.expressions)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Return the body."""
        return (self.body,)


@dataclass
class ForEach(Statement):
    """``for (type variable : array)``."""

    type: str
    variable: str
    array: Expr
    body: Block = field(default_factory=list)
    short: bool = False

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the array."""
        return (self.array,)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Return the body."""
        return (self.body,)


@dataclass
class While(Statement):
    """``while (test)``."""

    test: Expr
    body: Block = field(default_factory=list)
    short: bool = False

    @property
    def expressions(self) -> tuple[Expr, ...]:
        """Return the test."""
        return (self.test,)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Return the body."""
        return (self.body,)


@dataclass(frozen=True)
class Lambda(Expr):
    """``[](arguments) { body }``."""

    arguments: tuple[str, ...]
    body: tuple[Statement, ...]

    @cached_property
    def names(self) -> frozenset[str]:
        """Return the names in its body, its arguments among them."""
        return names_in([*self.body])


BREAK, CONTINUE = Jump("break"), Jump("continue")


def const(type_: str, name: str, value: Operand) -> Declare:
    """Return ``const type name = value;``."""
    return Declare(f"const {type_}", name, of(value))


def var(type_: str, name: str, value: Operand) -> Declare:
    """Return ``type name = value;``."""
    return Declare(type_, name, of(value))


def zeroed(type_: str, name: str) -> Declare:
    """Return ``type name{};``."""
    return Declare(f"{type_}", name, Braces("", ()))


def assign(target: Operand, value: Operand, sign: str = "=") -> Assign:
    """Return ``target = value;``."""
    return Assign(of(target), sign, of(value))


def when(test: Operand, *then: Statement, short: bool = True) -> If:
    """Return ``if (test) then``."""
    return If([(of(test), list(then))], short=short)


def increment(name: Operand) -> Do:
    """Return ``++name;``."""
    return Do(Prefix("++", of(name)))


def for_range(variable: str, first: Operand, last: Operand, type_: str = "std::int32_t") -> For:
    """Return the loop from ``first`` to ``last`` inclusive."""
    return For(type_, variable, of(first), op(variable, "<=", last), increment(variable))


def for_below(variable: str, end: Operand, type_: str = "std::int32_t") -> For:
    """Return the loop from 0 up to before ``end``."""
    return For(type_, variable, of(0), op(variable, "<", end), increment(variable))


def for_down(variable: str, length: int, type_: str = "int") -> For:
    """Return the loop from ``length - 1`` down to 0."""
    return For(type_, variable, of(length - 1), op(variable, ">=", 0), Do(Prefix("--", Name(variable))))


# Functions ---------------------------------------------------------------------------------------


@dataclass
class Function:
    """A function: where it comes from, how it is called, and its body."""

    result: str
    name: str
    arguments: list[tuple[str, str]]  # types and names
    body: Block
    comment: tuple[str, ...] = ()
    mark: str = "HYPGEN_FN static"  # what stands before the result
    template: tuple[str, ...] = ()  # its parameters


def walk(block: Block) -> Iterator[Statement]:
    """Yield all statements of a block, and of the blocks in it."""
    for statement in block:
        yield statement
        for inner in statement.blocks:
            yield from walk(inner)


def names_in(block: Block) -> frozenset[str]:
    """Return all names that the expressions of a block have."""
    return frozenset(name for statement in walk(block) for name in statement.names)
