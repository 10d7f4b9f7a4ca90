"""What an expression is checked in: locals, the element, the prime, and what conditions have shown."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from hypgen.dsl import ast, ir
from hypgen.dsl.mistakes import mistake
from hypgen.dsl.source import Span
from hypgen.dsl.types import Int, Type

if TYPE_CHECKING:
    from hypgen.dsl.program import Program

Facts = Mapping[Hashable, tuple[int, int]]
_OPPOSITE = {"lt": "ge", "ge": "lt", "le": "gt", "gt": "le", "eq": "ne", "ne": "eq"}
_MIRRORED = {"lt": "gt", "gt": "lt", "le": "ge", "ge": "le", "eq": "eq", "ne": "ne"}


_MAX_STEPS = 1 << 18  # of expressions checked while evaluating: two seconds


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
class Scope:
    """The surroundings of an expression; immutable, so that every branch has its own.

    ``owner`` is the declaration whose reads are recorded (``update rover.x``), None where reads do not count:
    in constant expressions and where ``evaluate`` follows calls and lets and unfolds quantifiers to find
    values. ``action`` is then the action's value, if it is known. ``constant`` refuses what is not known when
    the model is compiled. ``history``: the policy's memory, lets and ``last(..)`` can be read. ``open_ints``:
    this is the body of a function with a formal of type ``int``, whose ranges are proven at each call.
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

    def check(self, node: ast.Expr, expected: Type | None = None) -> ir.Expr:
        """Return ``node`` as a typed expression; ``expected`` helps to resolve names but is not enforced."""
        return self.program.check(node, self, expected)

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
        facts = dict(self.facts)
        _learn(condition, holds, facts)
        return replace(self, facts=facts) if facts != self.facts else self

    def narrow(self, e: ir.Expr) -> ir.Expr:
        """Return a read with what conditions have shown of it."""
        key = _key(e) if self.facts and isinstance(e.type, Int) else None
        known = self.facts.get(key) if key is not None else None
        if known is None or not isinstance(e.type, Int):
            return e
        low, high = max(known[0], e.type.low), min(known[1], e.type.high)
        return replace(e, type=Int(low, high)) if low <= high else e


def _key(e: ir.Expr) -> Hashable:
    """Return what identifies a plain read whatever is known of its type, or None."""
    match e:
        case ir.Const(_, value):
            return ("const", value)
        case ir.Local(_, name):
            return ("local", name)
        case ir.FieldRead(_, _, name, operand):
            inner = _key(operand)
            return None if inner is None else ("field", name, inner)
        case ir.StateRead(_, name, indices, primed):
            return _read_key(("state", name, primed), indices)
        case ir.LetRead(_, name, indices, primed):
            return _read_key(("let", name, primed), indices)
        case ir.ParamRead(_, name, indices):
            return _read_key(("param", name), indices)
        case ir.TableRead(_, name, indices):
            return _read_key(("table", name), indices)
        case ir.ActionRead(_, indices):
            return _read_key(("action",), indices)
        case ir.MemoryRead(_, name, indices):
            return _read_key(("memory", name), indices)
    return None


def _read_key(head: tuple[Hashable, ...], indices: tuple[ir.Expr, ...]) -> Hashable:
    keys = tuple(map(_key, indices))
    return None if None in keys else (*head, keys)


def _learn(condition: ir.Expr, holds: bool, facts: dict[Hashable, tuple[int, int]]) -> None:
    match condition:
        case ir.Unary(_, "not", operand):
            _learn(operand, not holds, facts)
        case ir.Binary(_, "and" | "or" as op, left, right) if holds == (op == "and"):
            _learn(left, holds, facts)
            _learn(right, holds, facts)
        case ir.Binary(_, op, left, right) if op in _OPPOSITE and isinstance(left.type, Int):
            shown = op if holds else _OPPOSITE[op]
            _limit(left, shown, right, facts)
            _limit(right, _MIRRORED[shown], left, facts)


def _limit(read: ir.Expr, op: str, other: ir.Expr, facts: dict[Hashable, tuple[int, int]]) -> None:
    """Note what ``read op other`` says of ``read``, given the interval of ``other``."""
    key = _key(read)
    if key is None or isinstance(read, ir.Const) or not isinstance(read.type, Int):
        return
    assert isinstance(other.type, Int)
    low, high = facts.get(key, (read.type.low, read.type.high))
    least, most = other.type.low, other.type.high
    match op:
        case "lt":
            high = min(high, most - 1)
        case "le":
            high = min(high, most)
        case "gt":
            low = max(low, least + 1)
        case "ge":
            low = max(low, least)
        case "eq":
            low, high = max(low, least), min(high, most)
        case "ne" if least == most:
            low, high = low + (low == least), high - (high == least)
    if low <= high:
        facts[key] = (low, high)
