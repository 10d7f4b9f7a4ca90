# SPDX-License-Identifier: Apache-2.0
"""Passes over functions of C++: what a person would not have written is not there.

Each pass leaves what a function computes as it is, operation by operation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from hypgen.codegen.tree.expr import Call, Expr, Member, Name, Operation, Postfix, Prefix, number
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
from hypgen.codegen.tree.walks import all_nodes, calls, declared, integer, nodes, root, with_values

_OWN = ("math::",)  # functions that change nothing


def tidy(functions: Sequence[Function]) -> list[Function]:
    """Return functions with loops of one trip written out and equal neighbours merged."""
    known = {f.name: f for f in functions}
    return [_tidy(f, known) for f in functions]


def _tidy(function: Function, known: Mapping[str, Function]) -> Function:
    body = Unrolling(function).block(function.body)
    return replace(function, body=Merging(function, known).block(body))


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


@dataclass
class Merging(Rewriting):
    """Merges neighbours that ask the same conditions, where the first does not change the answer."""

    function: Function
    known: Mapping[str, Function]

    def __post_init__(self) -> None:
        self.constant = {name for kind, name in self.function.arguments if kind.startswith("const ")}

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
        if conditions != second.expressions or not all(map(self._is_pure, conditions)):
            return False
        for one, other in zip(first.blocks, second.blocks, strict=True):
            if declared(one) & declared(other) or any(isinstance(s, Jump | Return) for s in walk(one)):
                return False
        read = {name for condition in conditions for name in condition.names}
        changed = {name for block in first.blocks for name in self._changed(block)}
        return not read & (changed - self.constant)

    def _is_pure(self, condition: Expr) -> bool:
        """Return whether to evaluate a condition changes nothing and gives the same again."""
        return "draws" not in condition.names and not any(self._changed_by(n) for n in nodes(condition))

    def _changed(self, block: Block) -> Iterator[str | None]:
        """Yield the variables that a block may change."""
        for statement in walk(block):
            match statement:
                case Assign(target=target):
                    yield root(target)
                case Declare(name=name) | For(variable=name) | ForEach(variable=name):
                    yield name
        for node in all_nodes(block):
            yield from self._changed_by(node)

    def _changed_by(self, node: Expr) -> set[str | None]:
        """Return the variables that an expression itself may change."""
        match node:
            case Prefix(sign="++" | "--" | "&", operand=operand) | Postfix(operand=operand):
                return {root(operand)}
            case Call(function=Member(owner=owner)):
                return {root(owner)} - self.constant
            case Call(function=Name(text=name), arguments=arguments) if name in self.known:
                kinds = [kind for kind, _ in self.known[name].arguments]
                given = zip(kinds, arguments, strict=True)
                return {root(a) for kind, a in given if kind[-1] in "&*" and not kind.startswith("const ")}
            case Call(function=Name(text=name), arguments=arguments) if not name.startswith(_OWN):
                return {root(a) for a in arguments} - self.constant - {None}
        return set()


def _merged(first: If, second: If) -> If:
    both = zip(first.branches, second.branches, strict=True)
    branches = [(condition, [*one, *other]) for (condition, one), (_, other) in both]
    return replace(first, branches=branches, otherwise=[*first.otherwise, *second.otherwise])
