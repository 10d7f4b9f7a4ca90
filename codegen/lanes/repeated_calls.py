# SPDX-License-Identifier: Apache-2.0
"""Calls that a block makes twice, made once: compilers do not see that such calls in lanes repeat."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from hypgen.codegen.tree.expr import Call, Expr, Literal, Member, Name
from hypgen.codegen.tree.passes import Rewriting
from hypgen.codegen.tree.statements import (
    Assign,
    Block,
    Declare,
    Do,
    For,
    ForEach,
    Function,
    Statement,
    const,
    walk,
)
from hypgen.codegen.tree.walks import mapped, nodes, root


def without_repeated_calls(functions: Sequence[Function]) -> list[Function]:
    """Return functions in lanes, each block with a local for what it calls more than once."""
    known = {f.name: f for f in functions}
    return [replace(f, body=_Sharing(f, known).block(f.body)) for f in functions]


class _Sharing(Rewriting):
    def __init__(self, function: Function, known: Mapping[str, Function]) -> None:
        self.known = known
        body = function.body
        self.taken = {n for s in walk(body) for n in s.names} | {name for _, name in function.arguments}
        self.taken |= {s.name for s in walk(body) if isinstance(s, Declare)}
        self.changing = {name for kind, name in function.arguments if not kind.startswith("const ")}
        self.changing -= {
            name for kind, name in function.arguments if kind in ("lanes::Mask", "lanes::Draws&")
        }
        for statement in walk(body):
            self.changing |= self._changed(statement)

    def _changed(self, statement: Statement) -> set[str]:
        """Return the variables that a statement changes, or declares as such that change."""
        match statement:
            case Assign(target=target):
                return {root(target) or ""}
            case Declare(type=kind, name=name) if not kind.startswith(("const ", "static ")):
                return {name}
            case Do(Call(function=Member(owner=owner))):
                return {root(owner) or ""}
            case Do(Call(function=Literal(), arguments=arguments)):
                return {root(a) or "" for a in arguments[1:2]}
        return set()

    def block(self, block: Block) -> Block:
        """Return a block with its repeated calls made once, and what is in it."""
        found = Counter(node for s in block for node in self._calls(s))
        repeated = [call for call, times in found.items() if times > 1]
        if not repeated:
            return super().block(block)
        call = max(repeated, key=lambda c: sum(1 for _ in nodes(c)))  # an outer one holds its inner ones
        assert isinstance(call.function, Name)
        name, n = f"{call.function.text}_now", 2
        while name in self.taken:
            name, n = f"{call.function.text}_now_{n}", n + 1
        self.taken.add(name)
        first = next(i for i, s in enumerate(block) if call in self._calls(s))

        def change(expr: Expr) -> Expr | None:
            return Name(name) if expr == call else None

        rest = [mapped(s, change) for s in block[first:]]
        return self.block([*block[:first], const("auto", name, call), *rest])

    def _calls(self, statement: Statement) -> list[Call]:
        """Return the calls of a statement's own expressions that give the same wherever they stand."""
        if isinstance(statement, For | ForEach):
            return []
        return [
            node
            for expr in statement.expressions
            for node in nodes(expr)
            if isinstance(node, Call) and self._is_constant(node)
        ]

    def _is_constant(self, call: Call) -> bool:
        if not isinstance(call.function, Name) or call.function.text not in self.known or call.function.given:
            return False
        kinds = [kind for kind, _ in self.known[call.function.text].arguments]
        if any(k[-1] in "&*" and not k.startswith("const ") and k != "lanes::Draws&" for k in kinds):
            return False
        return not call.names & self.changing
