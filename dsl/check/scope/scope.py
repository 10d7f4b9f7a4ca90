# SPDX-License-Identifier: Apache-2.0
"""What an expression is checked in: ``Scope``, and ``Program``, the declarations that it may ask for.

A scope has the locals, the element, the prime, and what conditions have shown. The two stand in one file, as
each is made of the other: a scope knows its program, and a program checks expressions in scopes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Uses
from hypgen.dsl.check.scope.symbols import Symbols
from hypgen.dsl.ir.facts import Facts, learned, narrowed
from hypgen.dsl.ir.inline import applied
from hypgen.dsl.messages import e02_names, e06_ranges
from hypgen.dsl.messages.report import Mistake, Report
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Type

# Of expressions checked one by one while evaluating: a third of a second on a slow core. Entries of tables
# and quantifiers over constants run as closures, and have a limit of their own.
_MAX_STEPS = 3 << 13


class Budget:
    """How much may still be evaluated for one declaration; calls of calls would go on for hours."""

    def __init__(self) -> None:
        self._left = _MAX_STEPS
        self._start: Span | None = None

    def spend(self, span: Span) -> None:
        """Count a step, of the expression at ``span``; raises, at the first, if there are too many."""
        self._start = self._start or span
        self._left -= 1
        if self._left < 0:
            raise Mistake(e06_ranges.many_steps(self._start))


@dataclass(frozen=True)
class Falling:
    """A call of a recursive function that is being unrolled, with the formals that are constant in it."""

    function: str
    constants: Mapping[str, int]


@dataclass(frozen=True)
class Asked:
    """A ``belief(..)`` or ``deviation(..)`` of the text: its place, and what its expression's reads are
    recorded under.
    """

    span: Span
    owner: Owner
    function: str = "belief"


class Program(Protocol):
    """What a check may ask of the model file: its declarations, each checked when it is first asked for.

    A declaration with mistakes has reported them, and raises a ``Mistake`` without diagnostics for all who
    ask for it. ``check.program`` has the one implementation.
    """

    file: ast.ModelFile
    overrides: Mapping[str, ast.Expr]
    """The values that settings give to consts and params."""
    symbols: Symbols
    report: Report
    uses: Uses
    """Who reads what, as far as expressions have been checked."""
    float_equalities: dict[Owner, dict[Span, None]]
    """Where each declaration compares floats with ``==`` or ``!=``."""
    unrolled: dict[str, ir.Function]
    """The copies of recursive functions, by their names."""
    literals: list[ir.ConstantArray]
    """The tables of definitions whose entries are listed."""
    beliefs: list[Asked]
    """The ``belief(..)`` reads, by their numbers."""

    @property
    def recursive(self) -> frozenset[str]:
        """Return the names of the functions that come to call themselves."""

    def check(self, node: ast.Expr, scope: Scope, expected: Type | None = None) -> ir.Expr:
        """Return ``node`` as a typed expression."""

    def draw(self, node: ast.Expr, scope: Scope, target: Type | None, what: str) -> ir.Dist:
        """Return the distribution that ``node`` writes."""

    def type_of(self, node: ast.TypeExpr) -> Type:
        """Return the type that ``node`` writes."""

    def named_type(self, item: ast.TypeAlias | ast.EnumDecl | ast.RecordDecl) -> Type:
        """Return a declared type."""

    def const(self, item: ast.Const) -> ir.Const | ir.ConstantArray:
        """Return a const's value under the settings."""

    def param(self, item: ast.Param) -> ir.Param:
        """Return a param with its default under the settings."""

    def discount(self, span: Span) -> float:
        """Return the discount, which ``span`` asks for."""

    def action(self, item: ast.Action) -> ir.Action:
        """Return the action."""

    def element(self, name: str) -> ir.Element:
        """Return an element."""

    def variable(self, element: str, item: ast.Variable) -> ir.Variable:
        """Return a variable of ``element``."""

    def let(self, element: str, item: ast.Let) -> ir.Let:
        """Return a let of ``element``."""

    def policy_let(self, item: ast.Let) -> ir.Let:
        """Return a let of the policy."""

    def memory(self, item: ast.Memory) -> tuple[Type, tuple[Type, ...]]:
        """Return the types of a register's entries and of its indexes."""

    def formals(self, item: ast.Function) -> tuple[ir.Binder, ...]:
        """Return a function's formals."""

    def function(self, item: ast.Function) -> ir.Function:
        """Return a function."""

    def named_distribution(self, item: ast.Function) -> ir.Dist:
        """Return the distribution that a function names, over its formals as locals."""

    def number_call(self) -> int:
        """Return a number that no call of a named distribution has had."""

    def copy(self, name: str, item: ast.Function, frames: tuple[Falling, ...]) -> ir.Function:
        """Return the copy of a recursive function for the constants of the last of ``frames``."""

    def follow_let(self, element: str, item: ast.Let, member: tuple[ir.Expr, ...], scope: Scope) -> ir.Expr:
        """Return the value of a let where ``scope`` evaluates."""

    def follow_call(self, item: ast.Function, arguments: list[ir.Expr], scope: Scope) -> ir.Expr:
        """Return the value of a call where ``scope`` evaluates."""


@dataclass(frozen=True)
class Scope:
    """The surroundings of an expression; immutable, so that every branch has its own.

    ``owner`` is the declaration whose reads are recorded, None where reads do not count:
    in constant expressions and where ``evaluate`` follows calls and lets and unfolds quantifiers to find
    values. ``action`` is then the action's value, if it is known. ``constant`` refuses what is not known when
    the model is compiled. ``history``: the policy's memory, lets and ``last(..)`` can be read. ``open_ints``:
    this is the body of a function with a formal of type ``int``, whose ranges are proven at each call.
    ``unrolling`` are the calls of recursive functions that led here, the innermost last.
    """

    program: Program
    owner: Owner | None = None
    element: str | None = None
    locals: Mapping[str, ir.Expr] = field(default_factory=dict)
    primed: bool = False
    facts: Facts = field(default_factory=dict)
    evaluate: bool = False
    constant: bool = False
    action: ir.Const | None = None
    budget: Budget = field(default_factory=Budget, compare=False)
    history: bool = False
    open_ints: bool = False
    unrolling: tuple[Falling, ...] = ()

    @property
    def kind(self) -> str:
        """Return what kind of declaration this is in, for messages; nothing if reads do not count."""
        return "" if self.owner is None else self.owner.kind

    def check(self, node: ast.Expr, expected: Type | None = None) -> ir.Expr:
        """Return ``node`` as a typed expression; ``expected`` helps to resolve names but is not enforced."""
        return self.program.check(node, self, expected)

    def draw(self, node: ast.Expr, target: Type | None, what: str) -> ir.Dist:
        """Return the distribution that ``node`` writes, over ``target`` (None: over its own type)."""
        return self.program.draw(node, self, target, what)

    def bind(self, name: str, value: ir.Expr, span: Span) -> Scope:
        """Return this scope with a local more, which must not shadow anything."""
        if name in self.locals:
            raise Mistake(e02_names.shadows_local(name, span))
        self.program.symbols.refuse_shadow(name, self.element, span, in_policy=self.history)
        return replace(self, locals={**self.locals, name: value})

    def fresh(self, stem: str) -> str:
        """Return a name for a local that the author did not write."""
        number = 1
        while f"{stem}_{number}" in self.locals or self.program.symbols.is_taken(f"{stem}_{number}"):
            number += 1
        return f"{stem}_{number}"

    def hide(self, name: str, value: ir.Expr) -> Scope:
        """Return this scope with a local under a name from ``fresh``."""
        return replace(self, locals={**self.locals, name: value})

    def prime(self) -> Scope:
        """Return this scope with every state read primed."""
        return replace(self, primed=True)

    def given(self, condition: ir.Expr, holds: bool = True) -> Scope:
        """Return this scope where ``condition`` is known to hold, or not to."""
        found = learned(condition, holds, self.facts, self._meaning)
        return replace(self, facts=found) if found != self.facts else self

    def narrow(self, e: ir.Expr) -> ir.Expr:
        """Return a number with what conditions have shown of it."""
        return narrowed(e, self.facts) if self.facts else e

    def _meaning(self, e: ir.Expr) -> ir.Expr | None:
        """Return the body of what a condition calls, or of the let that it reads, in the caller's terms."""
        symbols = self.program.symbols
        match e:
            case ir.Call(_, name, arguments, primed):
                function = self.program.unrolled.get(name)
                if function is None:
                    function = self.program.function(symbols.functions[name])
                return applied(function.body, [f.name for f in function.formals], arguments, primed)
            case ir.LetRead(_, name, indices, primed):
                element, _, own = name.partition(".")
                declared = symbols.members.get(element, {}).get(own)
                if not isinstance(declared, ast.Let) or declared.rhs.draw:
                    return None
                let = self.program.let(element, declared)
                if not isinstance(let.dist, ir.Certain):
                    return None
                formals = [] if let.binder is None else [let.binder.name]
                return applied(let.dist.value, formals, indices, primed)
        return None
