# SPDX-License-Identifier: Apache-2.0
"""The reads of an expression, member by member, and what it asks of the action.

``rock[r].good`` with r the family's own binder is one member's flag; through an index that is only known in a
step it is any member's. Functions and lets are followed with the arguments that they are given, which
``ir.reads`` does not keep apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TypeAlias

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Node, bound_names, children
from hypgen.dsl.types import Enum, Type, length_of, low_of, size_of

Values: TypeAlias = Mapping[str, int]  # of locals that are known
Entry: TypeAlias = tuple[str, int | None]  # a variable, and the position of a family's member
Term: TypeAlias = tuple[ir.Reward, int | None]  # a reward, and the position of the member that earns it
Question: TypeAlias = tuple[str, str, int]  # what is asked of the action: a kind, a variant, a value


@dataclass
class Reads:
    """Variables and of which members, questions to the action, and whether outcomes can be enumerated."""

    entries: set[Entry] = field(default_factory=set)
    questions: set[Question] = field(default_factory=set)
    endless: bool = False  # a draw from a continuous law that nothing bins

    def add(self, other: Reads) -> None:
        """Take in what ``other`` has."""
        self.entries |= other.entries
        self.questions |= other.questions
        self.endless |= other.endless


class Reader:
    """Finds the reads of one model's expressions."""

    def __init__(self, model: ir.Model) -> None:
        self.model = model
        self._families = {e.name: e.binder for e in model.elements if e.binder is not None}
        self._variables = {v.name: v for v in model.variables}
        self._functions = {f.name: f for f in model.functions}
        self._lets = {let.name: let for let in model.lets}
        self._known: dict[tuple[str, tuple[int | None, ...]], Reads] = {}

    def of(self, node: Node, values: Values) -> Reads:
        """Return what ``node`` reads where locals have these values."""
        found = Reads()
        self._visit(node, values, found)
        return found

    def members(self, variable: str) -> list[int | None]:
        """Return the positions of the members that have the variable."""
        binder = self._families.get(self._variables[variable].element)
        return [None] if binder is None else list(range(size_of(binder.type)))

    @staticmethod
    def known(binder: ir.Binder | None, member: int | None) -> dict[str, int]:
        """Return the value of a family's binder for a member."""
        return {} if binder is None or member is None else {binder.name: member + low_of(binder.type)}

    def _visit(self, node: Node, values: Values, found: Reads) -> None:
        hidden = set(bound_names(node))
        if hidden & values.keys():
            values = {name: value for name, value in values.items() if name not in hidden}
        if (question := _question(node, values)) is not None:
            found.questions.add(question)
            for inner in _beside_the_action(node):
                self._visit(inner, values, found)
            return
        match node:
            case ir.StateRead(variable=name, indices=indices):
                found.entries |= self._entries(name, indices, values)
            case ir.Call(function=name, arguments=arguments):
                function = self._functions[name]
                formals = [f.name for f in function.formals]
                found.add(self._callee(name, function.body, formals, arguments, values))
            case ir.LetRead(let=name, indices=indices):
                let = self._lets[name]
                formals = [] if let.binder is None else [let.binder.name]
                found.add(self._callee(name, let.dist, formals, indices, values))
            case ir.Binned():  # whatever is drawn becomes one of finitely many values
                law = Reads()
                for child in children(node):
                    self._visit(child, values, law)
                found.add(replace(law, endless=False))
                return
            case ir.Continuous():
                found.endless = True
        for child in children(node):
            self._visit(child, values, found)

    def _entries(self, name: str, indices: tuple[ir.Expr, ...], values: Values) -> set[Entry]:
        binder = self._families.get(self._variables[name].element)
        member = None if binder is None else _value(indices[0], values)
        if binder is not None and member is not None:
            return {(name, member - low_of(binder.type))}
        return {(name, m) for m in self.members(name)}

    def _callee(
        self, name: str, body: Node, formals: list[str], arguments: tuple[ir.Expr, ...], values: Values
    ) -> Reads:
        given = tuple(_value(a, values) for a in arguments)
        if (name, given) not in self._known:
            inner = {f: v for f, v in zip(formals, given, strict=True) if v is not None}
            self._known[name, given] = self.of(body, inner)
        return self._known[name, given]


def terms_of(reward: ir.Reward) -> list[Term]:
    """Return a reward's terms, one for each member that earns it."""
    if reward.binder is None:
        return [(reward, None)]
    return [(reward, member) for member in range(size_of(reward.binder.type))]


def alike(action: ir.Action, questions: set[Question]) -> tuple[int, ...]:
    """Return the codes of actions that answer the questions differently, the first of those that agree."""
    answers: dict[tuple[int, ...], int] = {}
    for code in range(size_of(action.type)):
        answers.setdefault(tuple(_answer(action.type, code, q) for q in sorted(questions)), code)
    size, codes = size_of(action.type), [0]
    for _ in range(length_of(action.indices)):
        codes = [code * size + digit for code, digit in product(codes, answers.values())]
    return tuple(codes)


def _question(node: Node, values: Values) -> Question | None:
    """Return what ``node`` asks of the action, if it tells no more of it than that."""
    match node:
        case ir.Binary(op="eq" | "ne", left=ir.ActionRead(), right=right):
            value = _value(right, values)
            return ("any", "", 0) if value is None else ("is", "", value)
        case ir.IsVariant(variant=variant, operand=ir.ActionRead()):
            return "variant", variant, 0
        case ir.Binary(op="eq" | "ne", left=ir.VariantArgument(operand=ir.ActionRead()) as left, right=right):
            value = _value(right, values)
            return ("argument", left.variant, 0) if value is None else ("argument is", left.variant, value)
        case ir.VariantArgument(variant=variant, operand=ir.ActionRead()):
            return "argument", variant, 0
        case ir.ActionRead():
            return "any", "", 0
    return None


def _beside_the_action(node: Node) -> tuple[ir.Expr, ...]:
    """Return what a question reads besides the action itself."""
    match node:
        case ir.ActionRead(indices=indices):
            return indices
        case ir.Binary(left=left, right=right):
            return (*_beside_the_action(left), right)
        case ir.IsVariant(operand=operand) | ir.VariantArgument(operand=operand):
            return _beside_the_action(operand)
    return ()


def _answer(type_: Type, code: int, question: Question) -> int:
    kind, variant, value = question
    if kind == "any":
        return code
    if kind == "is":
        return int(code + low_of(type_) == value)
    assert isinstance(type_, Enum)
    found = type_.variant(variant)
    assert found is not None
    position = code - type_.offsets[variant]
    inside = 0 <= position < (1 if found.argument is None else size_of(found.argument))
    if kind == "variant" or not inside:
        return int(inside) - 1
    assert found.argument is not None
    return position if kind == "argument" else int(position + low_of(found.argument) == value)


def _value(e: ir.Expr, values: Values) -> int | None:
    match e:
        case ir.Const(value=value) if not isinstance(value, float):
            return int(value)
        case ir.Local(name=name):
            return values.get(name)
        case ir.MakeVariant(enum=enum, variant=name, argument=argument):
            inner, variant = _value(argument, values), enum.variant(name)
            if inner is not None and variant is not None and variant.argument is not None:
                return enum.offsets[name] + inner - low_of(variant.argument)
    return None
