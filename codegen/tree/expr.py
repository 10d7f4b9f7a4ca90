# SPDX-License-Identifier: Apache-2.0
"""Expressions of C++ as a tree. They never change.

Where an expression is wanted, a str stands for the variable of that name and an int for the number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

# How tightly an expression binds.
PRIMARY, UNARY, MULTIPLY, ADD, COMPARE, EQUAL, AND, OR, TERNARY = 100, 90, 80, 70, 60, 55, 40, 30, 20

_LEVELS = {
    **dict.fromkeys(("*", "/", "%"), MULTIPLY),
    **dict.fromkeys(("+", "-"), ADD),
    **dict.fromkeys(("<<", ">>"), ADD - 1),
    **dict.fromkeys(("<", "<=", ">", ">="), COMPARE),
    **dict.fromkeys(("==", "!="), EQUAL),
    "&": EQUAL - 1,
    "&&": AND,
    "||": OR,
}


class Expr:
    """An expression; operators make larger ones."""

    @property
    def level(self) -> int:
        """Return how tightly it binds."""
        return PRIMARY

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the expressions that this one consists of."""
        return ()

    @cached_property
    def names(self) -> frozenset[str]:
        """Return the names of variables and functions in it."""
        return frozenset().union(*(child.names for child in self.children))

    def __add__(self, other: Operand) -> Expr:
        return op(self, "+", other)

    def __sub__(self, other: Operand) -> Expr:
        return op(self, "-", other)

    def __mul__(self, other: Operand) -> Expr:
        return op(self, "*", other)

    def __truediv__(self, other: Operand) -> Expr:
        return op(self, "/", other)

    def __mod__(self, other: Operand) -> Expr:
        return op(self, "%", other)

    def __getitem__(self, index: Operand) -> Expr:
        return Index(self, of(index))

    def call(self, member: str, *arguments: Operand) -> Expr:
        """Return the call of a member function."""
        return Call(Member(self, member), tuple(map(of, arguments)))


Operand = Expr | str | int


@dataclass(frozen=True)
class Name(Expr):
    """A variable, or a function as a value: of a template with what it is given."""

    text: str
    given: tuple[str, ...] = ()

    @cached_property
    def names(self) -> frozenset[str]:
        """Return the name."""
        return frozenset({self.text})


@dataclass(frozen=True)
class Literal(Expr):
    """A number, a string, or a constant that is no variable of the function."""

    text: str

    @property
    def level(self) -> int:
        """Return how tightly it binds: a sign is an operator."""
        return UNARY if self.text.startswith("-") else PRIMARY


@dataclass(frozen=True)
class Operation(Expr):
    """A binary operator between two operands."""

    left: Expr
    sign: str
    right: Expr

    @property
    def level(self) -> int:
        """Return how tightly the operator binds."""
        return _LEVELS[self.sign]

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the operands."""
        return (self.left, self.right)


@dataclass(frozen=True)
class Prefix(Expr):
    """A unary operator before its operand: ``! - & * ++ --``."""

    sign: str
    operand: Expr

    @property
    def level(self) -> int:
        """Return how tightly the operator binds."""
        return UNARY

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the operand."""
        return (self.operand,)


@dataclass(frozen=True)
class Postfix(Expr):
    """``x++`` or ``x--``."""

    operand: Expr
    sign: str

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the operand."""
        return (self.operand,)


@dataclass(frozen=True)
class Choice(Expr):
    """``condition ? then : otherwise``."""

    condition: Expr
    then: Expr
    otherwise: Expr

    @property
    def level(self) -> int:
        """Return how tightly the operator binds."""
        return TERNARY

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the condition and both values."""
        return (self.condition, self.then, self.otherwise)


@dataclass(frozen=True)
class Member(Expr):
    """``owner.name``."""

    owner: Expr
    member: str

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the owner."""
        return (self.owner,)


@dataclass(frozen=True)
class Index(Expr):
    """``array[index]``."""

    array: Expr
    index: Expr

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the array and the index."""
        return (self.array, self.index)


@dataclass(frozen=True)
class Call(Expr):
    """A call of a function or of a constructor."""

    function: Expr
    arguments: tuple[Expr, ...]

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the function and its arguments."""
        return (self.function, *self.arguments)


@dataclass(frozen=True)
class Braces(Expr):
    """``type{a, b}``; a list where there is no type."""

    type: str
    values: tuple[Expr, ...]
    rows: bool = False  # each value in a line of its own

    @property
    def children(self) -> tuple[Expr, ...]:
        """Return the values."""
        return self.values


TRUE, FALSE = Literal("true"), Literal("false")


def of(value: Operand) -> Expr:
    """Return an operand as an expression."""
    if isinstance(value, Expr):
        return value
    if isinstance(value, int):
        return number(value)
    return Name(value)


def number(value: int) -> Expr:
    """Return an int32 literal."""
    return Literal("(-2147483647 - 1)" if value == -(2**31) else str(value))


def op(left: Operand, sign: str, right: Operand) -> Expr:
    """Return a binary operation."""
    return Operation(of(left), sign, of(right))


def not_(operand: Operand) -> Expr:
    """Return ``!operand``."""
    return Prefix("!", of(operand))


def shifted(value: Operand, amount: int) -> Expr:
    """Return ``value + amount``."""
    if amount == 0:
        return of(value)
    return op(value, "+", amount) if amount > 0 else op(value, "-", -amount)


def plus(left: Operand, right: Operand) -> Expr:
    """Return the sum of two integers that do not overflow, without parentheses."""
    left, right = of(left), of(right)
    if left == number(0):
        return right
    if isinstance(right, Operation) and right.sign in ("+", "-"):
        return op(plus(left, right.left), right.sign, right.right)
    return op(left, "+", right)


def call(function: Operand, *arguments: Operand) -> Expr:
    """Return a call."""
    return Call(of(function), tuple(map(of, arguments)))


def member(owner: Operand, name: str) -> Expr:
    """Return ``owner.name``."""
    return Member(of(owner), name)


def method(owner: Operand, name: str, *arguments: Operand) -> Expr:
    """Return ``owner.name(arguments)``."""
    return of(owner).call(name, *arguments)


def braces(type_: str, *values: Operand) -> Expr:
    """Return ``type{values}``."""
    return Braces(type_, tuple(map(of, values)))


def cast(type_: str, value: Operand) -> Expr:
    """Return ``static_cast<type>(value)``."""
    return call(Literal(f"static_cast<{type_}>"), value)


def following(pointer: str) -> Expr:
    """Return ``*pointer++``."""
    return Prefix("*", Postfix(of(pointer), "++"))


def all_of(tests: Sequence[Expr], sign: str = "&&") -> Expr:
    """Return the conjunction, or the disjunction, of one test or more."""
    result = tests[0]
    for test in tests[1:]:
        result = op(result, sign, test)
    return result


def starts_with(expr: Expr, sign: str) -> bool:
    """Return whether the text of an expression starts with a unary operator."""
    if isinstance(expr, Prefix):
        return expr.sign == sign
    return isinstance(expr, Literal) and expr.text.startswith(sign)
