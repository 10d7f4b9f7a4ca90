# SPDX-License-Identifier: Apache-2.0
"""What statements and expressions of a function may change."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from hypgen.codegen.tree.expr import Call, Expr, Member, Name, Postfix, Prefix
from hypgen.codegen.tree.statements import Assign, Block, Declare, For, ForEach, Function, walk
from hypgen.codegen.tree.walks import all_nodes, nodes, root

_OWN = ("math::",)  # functions of the runtime that change nothing
_NUMBERS = ("bool", "float", "int", "std::int32_t")


@dataclass
class Effects:
    """Knows what a function's statements may change; ``known`` are the functions that it may call."""

    function: Function
    known: Mapping[str, Function]

    def __post_init__(self) -> None:
        self.constant = {name for kind, name in self.function.arguments if kind.startswith("const ")}
        # Nothing of the runtime takes a number by reference: only the function itself may change one.
        numbers = {name for kind, name in self.function.arguments if kind in _NUMBERS}
        self.constant |= numbers
        self.constant -= numbers & {*self._of(self.function.body)}

    def is_pure(self, expr: Expr) -> bool:
        """Return whether evaluating an expression draws and changes nothing, and gives the same again."""
        return "draws" not in expr.names and not any(self._by(node) for node in nodes(expr))

    def of(self, block: Block) -> set[str]:
        """Return the variables that a block may change, and those that it declares."""
        return {name for name in self._of(block) if name is not None} - self.constant

    def _of(self, block: Block) -> Iterator[str | None]:
        for statement in walk(block):
            match statement:
                case Assign(target=target):
                    yield root(target)
                case Declare(name=name) | For(variable=name) | ForEach(variable=name):
                    yield name
        for node in all_nodes(block):
            yield from self._by(node)

    def _by(self, node: Expr) -> set[str | None]:
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
