# SPDX-License-Identifier: Apache-2.0
"""The model's declarations, each checked when first needed and once.

A const may size a type that a function's formal has, which a const calls; so there is no fixed order.
``CheckedProgram`` computes what is asked for, reports a declaration's mistakes at the declaration, and tells
every user of a wrong one by a ``Mistake`` without diagnostics. It stands above all checks and wires them to
each other: they know it as the protocol ``Program`` (``scope.scope``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TypeVar

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Uses
from hypgen.dsl.check.constants import constants, settings
from hypgen.dsl.check.draws import distributions, named_distributions
from hypgen.dsl.check.expressions import expressions
from hypgen.dsl.check.parts import declarations, policies
from hypgen.dsl.check.scope import type_expressions
from hypgen.dsl.check.scope.scope import Asked, Falling, Scope
from hypgen.dsl.check.scope.symbols import Symbols
from hypgen.dsl.check.terms import recursion
from hypgen.dsl.messages import e02_names
from hypgen.dsl.messages.report import Mistake, Report
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Type

T = TypeVar("T")


class CheckedProgram:
    """A model file under its settings, with everything that has been checked so far."""

    def __init__(
        self, file: ast.ModelFile, overrides: Mapping[str, ast.Expr], symbols: Symbols, report: Report
    ) -> None:
        self.file = file
        self.overrides = overrides
        self.symbols = symbols
        self.report = report
        self.uses = Uses()
        self.float_equalities: dict[Owner, dict[Span, None]] = {}  # where each declaration has them
        self.unrolled: dict[str, ir.Function] = {}  # copies of recursive functions
        self.literals: list[ir.ConstantArray] = []  # of definitions whose entries are listed
        self.beliefs: list[Asked] = []
        self._done: dict[str, object] = {}
        self._failed: set[str] = set()
        self._active: dict[str, Span] = {}
        self._calls = 0

    def _demand(self, key: str, span: Span, compute: Callable[[], T]) -> T:
        """Return what ``compute`` gives for the declaration ``key`` at ``span``, computing it once."""
        if key in self._done:
            return self._done[key]  # type: ignore[return-value]  # a key has one kind of value
        if key in self._failed:
            raise Mistake()
        if key in self._active:
            cycle = list(self._active)[list(self._active).index(key) :]
            self._failed.update(cycle)
            # Told at once: what asks may catch a mistake and try another way, which then fails without one.
            self.report.add(Mistake(e02_names.circular_declaration([(k, self._active[k]) for k in cycle])))
            raise Mistake()
        self._active[key] = span
        try:
            value = compute()
        except Mistake as error:
            self.report.add(error)
            self._failed.add(key)
            raise Mistake() from None
        finally:
            del self._active[key]
        if key in self._failed:
            raise Mistake()
        self._done[key] = value
        return value

    def check(self, node: ast.Expr, scope: Scope, expected: Type | None = None) -> ir.Expr:
        """Return ``node`` as a typed expression."""
        return expressions.check(node, scope, expected)

    def draw(self, node: ast.Expr, scope: Scope, target: Type | None, what: str) -> ir.Dist:
        """Return the distribution that ``node`` writes."""
        return distributions.check(node, scope, target, what)

    def type_of(self, node: ast.TypeExpr) -> Type:
        """Return the type that ``node`` writes."""
        return type_expressions.resolve(node, self)

    def named_type(self, item: ast.TypeAlias | ast.EnumDecl | ast.RecordDecl) -> Type:
        """Return a declared type."""
        return self._demand(f"type {item.name}", item.span, lambda: type_expressions.declared(item, self))

    def const(self, item: ast.Const) -> ir.Const | ir.ConstantArray:
        """Return a const's value under the settings."""
        return self._demand(f"const {item.name}", item.span, lambda: constants.const(item, self))

    def param(self, item: ast.Param) -> ir.Param:
        """Return a param with its default under the settings."""
        return self._demand(f"param {item.name}", item.span, lambda: constants.param(item, self))

    def discount(self, span: Span) -> float:
        """Return the discount, which ``span`` asks for."""
        return self._demand("discount", span, lambda: settings.discount(self))

    def action(self, item: ast.Action) -> ir.Action:
        """Return the action."""
        return self._demand(f"action {item.name}", item.span, lambda: declarations.action(item, self))

    def element(self, name: str) -> ir.Element:
        """Return an element."""
        item = self.symbols.elements[name]
        return self._demand(f"element {name}", item.span, lambda: declarations.element(item, self))

    def variable(self, element: str, item: ast.Variable) -> ir.Variable:
        """Return a variable of ``element``."""
        key = f"variable {element}.{item.name}"
        return self._demand(key, item.span, lambda: declarations.variable(element, item, self))

    def let(self, element: str, item: ast.Let) -> ir.Let:
        """Return a let of ``element``."""
        key = f"let {element}.{item.name}"
        return self._demand(key, item.span, lambda: declarations.let(element, item, self))

    def policy_let(self, item: ast.Let) -> ir.Let:
        """Return a let of the policy."""
        return self._demand(f"let {item.name} of the policy", item.span, lambda: policies.let(item, self))

    def memory(self, item: ast.Memory) -> tuple[Type, tuple[Type, ...]]:
        """Return the types of a register's entries and of its indexes."""
        return self._demand(f"memory {item.name}", item.span, lambda: policies.memory(item, self))

    def formals(self, item: ast.Function) -> tuple[ir.Binder, ...]:
        """Return a function's formals."""
        return self._demand(f"formals of {item.name}", item.span, lambda: declarations.formals(item, self))

    def function(self, item: ast.Function) -> ir.Function:
        """Return a function."""
        return self._demand(f"fn {item.name}", item.span, lambda: declarations.function(item, self))

    def named_distribution(self, item: ast.Function) -> ir.Dist:
        """Return the distribution that a function names, over its formals as locals."""
        return self._demand(f"fn {item.name}", item.span, lambda: named_distributions.declared(item, self))

    def number_call(self) -> int:
        """Return a number that no call of a named distribution has had."""
        self._calls += 1
        return self._calls

    @cached_property
    def recursive(self) -> frozenset[str]:
        """Return the names of the functions that come to call themselves."""
        return recursion.recursive_functions(self)

    def copy(self, name: str, item: ast.Function, frames: tuple[Falling, ...]) -> ir.Function:
        """Return the copy of a recursive function for the constants of the last of ``frames``."""

        def compute() -> ir.Function:
            self.unrolled[name] = declarations.copy(name, item, frames, self)
            return self.unrolled[name]

        return self._demand(f"fn {name}", item.span, compute)

    def follow_let(self, element: str, item: ast.Let, member: tuple[ir.Expr, ...], scope: Scope) -> ir.Expr:
        """Return the value of a let where ``scope`` evaluates."""
        return declarations.follow_let(element, item, member, scope)

    def follow_call(self, item: ast.Function, arguments: list[ir.Expr], scope: Scope) -> ir.Expr:
        """Return the value of a call where ``scope`` evaluates."""
        return declarations.follow_call(item, arguments, scope)
