# SPDX-License-Identifier: Apache-2.0
"""Passes over functions of C++: what a person would not have written is not there.

Each pass leaves what a function computes as it is, operation by operation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from hypgen.codegen.tree.effects import Effects
from hypgen.codegen.tree.expr import FALSE, TRUE, Braces, Expr, Literal, Name, Operation, number
from hypgen.codegen.tree.statements import (
    Assign,
    Block,
    Declare,
    For,
    ForEach,
    Function,
    If,
    Jump,
    Return,
    Statement,
    While,
    names_in,
    walk,
)
from hypgen.codegen.tree.walks import calls, declared, integer, with_values

# What a value combined with another leaves as it is, to the bit.
_NEUTRAL: dict[str, Expr] = {"&=": TRUE, "|=": FALSE, "*=": Literal("1.0")}


def tidy(functions: Sequence[Function]) -> list[Function]:
    """Return functions with loops of one trip written out, equal neighbours merged, and nothing idle."""
    known = {f.name: f for f in functions}
    return [_tidy(f, known) for f in functions]


def _tidy(function: Function, known: Mapping[str, Function]) -> Function:
    effects = Effects(function, known)
    function = replace(function, body=Unrolling(function).block(function.body))
    function = replace(function, body=Merging(effects).block(function.body))
    function = replace(function, body=Starting(function.result).block(function.body))
    function = without_last_writes(function, effects)
    return replace(function, body=Dropping(function, effects).block(function.body))


def called(functions: Sequence[Function], removable: Sequence[str]) -> set[str]:
    """Return the names of functions that are called, or are none of ``removable``."""
    return calls(functions, {f.name for f in functions} - {*removable})


class Rewriting:
    """A pass over a body, block by block."""

    def block(self, block: Block) -> Block:
        """Return what the pass makes of a block."""
        return [new for statement in block for new in self.statement(self.inside(statement))]

    def inside(self, statement: Statement) -> Statement:
        """Return a statement with what the pass makes of its blocks."""
        match statement:
            case If(branches=branches, otherwise=otherwise):
                inner = [(condition, self.block(block)) for condition, block in branches]
                return replace(statement, branches=inner, otherwise=self.block(otherwise))
            case For(body=body) | ForEach(body=body) | While(body=body):
                return replace(statement, body=self.block(body))
        return statement

    def statement(self, statement: Statement) -> Block:
        """Return what the pass makes of a statement whose blocks it has been through."""
        return [statement]


class Unrolling(Rewriting):
    """Writes loops out that run once."""

    def __init__(self, function: Function) -> None:
        self.times = Counter(s.name for s in walk(function.body) if isinstance(s, Declare))

    def statement(self, statement: Statement) -> Block:
        """Return the body of a loop of one trip, with its variable's value."""
        if not isinstance(statement, For) or not isinstance(statement.test, Operation):
            return [statement]
        first, last = integer(statement.first), integer(statement.test.right)
        if first is None or first != last or statement.test.sign not in ("<=", ">="):
            return [statement]
        if any(isinstance(s, Jump) for s in walk(statement.body)):
            return [statement]
        if any(self.times[name] > 1 for name in declared(statement.body)):
            return [statement]  # the name may be another's behind the loop
        return with_values(statement.body, {statement.variable: number(first)})


class Merging(Rewriting):
    """Merges neighbours that ask the same conditions, where the first does not change the answer."""

    def __init__(self, effects: Effects) -> None:
        self.effects = effects

    def block(self, block: Block) -> Block:
        """Return a block with its neighbours merged, and what is in it."""
        result: Block = []
        for statement in block:
            before = result[-1] if result else None
            if isinstance(before, If) and isinstance(statement, If) and self._may_merge(before, statement):
                result[-1] = _merged(before, statement)
            else:
                result.append(statement)
        return [self.inside(statement) for statement in result]

    def _may_merge(self, first: If, second: If) -> bool:
        conditions = first.expressions
        if conditions != second.expressions or not all(map(self.effects.is_pure, conditions)):
            return False
        for one, other in zip(first.blocks, second.blocks, strict=True):
            if any(isinstance(s, Jump | Return) for s in walk(one)):
                return False
            if declared(one) & declared([s for s in other if not self._is_known(s, one)]):
                return False
        read = {name for condition in conditions for name in condition.names}
        return not any(read & self.effects.of(block) for block in first.blocks)

    def _is_known(self, statement: Statement, block: Block) -> bool:
        """Return whether a block declares the same constant, of what it does not change."""
        if not isinstance(statement, Declare) or not statement.type.startswith("const "):
            return False
        same = statement in block and all(map(self.effects.is_pure, statement.expressions))
        return same and not {*statement.names} & self.effects.of(block)


class Starting(Rewriting):
    """Lets a local start with what is combined with its first value, and returns what only goes back."""

    def __init__(self, result: str) -> None:
        self.result = result

    def block(self, block: Block) -> Block:
        """Return a block whose locals start with their values."""
        done: Block = []
        for statement in map(self.inside, block):
            before = done[-1] if done else None
            start = None
            if isinstance(before, Declare) and before.value is not None and not before.dimensions:
                start = self._start(before, before.value, statement)
            if start is None:
                done.append(statement)
            else:
                done[-1] = start
        return done

    def _start(self, before: Declare, first: Expr, statement: Statement) -> Statement | None:
        """Return what a declaration and the statement behind it are together, if they are one."""
        match statement:
            case Assign(target=Name(text=name), value=Operation(Operation(Name(text=by), "*"), "+", value)):
                if name == by == before.name and first == number(0) and name not in value.names:
                    return replace(before, value=value)
            case Assign(target=Name(text=name), sign=sign, value=value):
                if name == before.name and _NEUTRAL.get(sign) == first and name not in value.names:
                    return replace(before, value=value)
            case Return(value=Name(text=name)):
                same = before.type.removeprefix("const ") == self.result
                if name == before.name and same and not isinstance(first, Braces):
                    return Return(first)
        return None


def without_last_writes(function: Function, effects: Effects) -> Function:
    """Return a function that writes nothing into a local that nothing reads from there on."""
    own = {s.name for s in walk(function.body) if isinstance(s, Declare) and s.type[-1] not in "&*"}
    own |= {name for kind, name in function.arguments if kind[-1] not in "&*"}

    def read_on(block: Block, later: frozenset[str]) -> Block:
        kept: Block = []
        for statement in reversed(block):
            match statement:
                case Assign(target=Name(text=name), value=value) if name in own - later:
                    if effects.is_pure(value):
                        continue
                case If(branches=branches, otherwise=otherwise):
                    inner = [(condition, read_on(then, later)) for condition, then in branches]
                    statement = replace(statement, branches=inner, otherwise=read_on(otherwise, later))
                case For(body=body) | ForEach(body=body) | While(body=body):
                    again = names_in([statement])
                    statement = replace(statement, body=read_on(body, later | again))
            later |= names_in([statement])
            kept.append(statement)
        return kept[::-1]

    return replace(function, body=read_on(function.body, frozenset()))


class Dropping(Rewriting):
    """Drops statements without an effect, and locals that nothing reads."""

    def __init__(self, function: Function, effects: Effects) -> None:
        self.effects = effects
        self.unread = {
            s.name
            for s in walk(function.body)
            if isinstance(s, Declare) and not s.dimensions and not s.arguments
        }
        for statement in walk(function.body):
            if isinstance(statement, Assign) and isinstance(statement.target, Name):
                self.unread -= statement.value.names
                if not effects.is_pure(statement.value):
                    self.unread.discard(statement.target.text)
                continue
            self.unread.difference_update(statement.names)
            if isinstance(statement, Declare) and not all(map(effects.is_pure, statement.expressions)):
                self.unread.discard(statement.name)

    def statement(self, statement: Statement) -> Block:
        """Return the statement, unless it has no effect."""
        match statement:
            case Assign(sign="&=", value=value) if value == TRUE:
                return []
            case Assign(sign="|=", value=value) if value == FALSE:
                return []
            case Assign(sign="+=" | "-=", value=value) if value == number(0):
                return []
            case Assign(target=Name(text=name)) | Declare(name=name) if name in self.unread:
                return []
            case If() | For() | ForEach():
                if not any(statement.blocks) and all(map(self.effects.is_pure, statement.expressions[:2])):
                    return []
        return [statement]


def _merged(first: If, second: If) -> If:
    both = zip(first.branches, second.branches, strict=True)
    branches = [(condition, _joined(one, other)) for (condition, one), (_, other) in both]
    return replace(first, branches=branches, otherwise=_joined(first.otherwise, second.otherwise))


def _joined(one: Block, other: Block) -> Block:
    """Return two blocks as one, without declarations that the second repeats."""
    known = declared(one)
    return [*one, *(s for s in other if not (isinstance(s, Declare) and s.name in known))]
