# SPDX-License-Identifier: Apache-2.0
"""Passes over functions of C++: what a person would not have written is not there.

Each pass leaves what a function computes as it is, operation by operation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from hypgen.codegen.tree.effects import Effects
from hypgen.codegen.tree.expr import FALSE, TRUE, Name, Operation, number
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
    walk,
)
from hypgen.codegen.tree.walks import calls, declared, integer, with_values


def tidy(functions: Sequence[Function]) -> list[Function]:
    """Return functions with loops of one trip written out, equal neighbours merged, and nothing idle."""
    known = {f.name: f for f in functions}
    return [_tidy(f, known) for f in functions]


def _tidy(function: Function, known: Mapping[str, Function]) -> Function:
    effects = Effects(function, known)
    function = replace(function, body=Unrolling(function).block(function.body))
    function = replace(function, body=Merging(effects).block(function.body))
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
            if declared(one) & declared(other) or any(isinstance(s, Jump | Return) for s in walk(one)):
                return False
        read = {name for condition in conditions for name in condition.names}
        return not any(read & self.effects.of(block) for block in first.blocks)


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
    branches = [(condition, [*one, *other]) for (condition, one), (_, other) in both]
    return replace(first, branches=branches, otherwise=[*first.otherwise, *second.otherwise])
