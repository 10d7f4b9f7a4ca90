"""What an expression is checked in: locals, the element, the prime, and what conditions have shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from hypgen.dsl import ir
from hypgen.dsl.ir.facts import Facts, learned, narrowed
from hypgen.dsl.ir.inline import applied
from hypgen.dsl.messages.report import mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Type

if TYPE_CHECKING:
    from hypgen.dsl.check.program import Program


_MAX_STEPS = 1 << 15  # of expressions checked while evaluating: a third of a second


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
            raise mistake(
                "E0609",
                "this takes too many steps to compute",
                self._start,
                "compute less of it, with smaller types or fewer calls",
            )


@dataclass(frozen=True)
class Falling:
    """A call of a recursive function that is being unrolled, with the formals that are constant in it."""

    function: str
    constants: Mapping[str, int]


@dataclass(frozen=True)
class Scope:
    """The surroundings of an expression; immutable, so that every branch has its own.

    ``owner`` is the declaration whose reads are recorded (``update rover.x``), None where reads do not count:
    in constant expressions and where ``evaluate`` follows calls and lets and unfolds quantifiers to find
    values. ``action`` is then the action's value, if it is known. ``constant`` refuses what is not known when
    the model is compiled. ``history``: the policy's memory, lets and ``last(..)`` can be read. ``open_ints``:
    this is the body of a function with a formal of type ``int``, whose ranges are proven at each call.
    ``unrolling`` are the calls of recursive functions that led here, the innermost last.
    """

    program: Program
    owner: str | None = None
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

    def check(self, node: ast.Expr, expected: Type | None = None) -> ir.Expr:
        """Return ``node`` as a typed expression; ``expected`` helps to resolve names but is not enforced."""
        return self.program.check(node, self, expected)

    def draw(self, node: ast.Expr, target: Type | None, what: str) -> ir.Dist:
        """Return the distribution that ``node`` writes, over ``target`` (None: over its own type)."""
        return self.program.draw(node, self, target, what)

    def bind(self, name: str, value: ir.Expr, span: Span) -> Scope:
        """Return this scope with a local more, which must not shadow anything."""
        if name in self.locals:
            raise mistake(
                "E0202", f"'{name}' shadows an outer local of that name", span, "choose another name"
            )
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
                    item = symbols.globals[name]
                    assert isinstance(item, ast.Function)
                    function = self.program.function(item)
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
