# SPDX-License-Identifier: Apache-2.0
"""Expressions that may be evaluated outside of the conditions that stand around them.

Conditions narrow the intervals of what is read where they hold: ``if x > 6 then log(x - 5) else 0`` needs a
table of two entries, whose index is out of range wherever the condition fails. Inlining puts expressions in
the place of a function's formals, whose intervals its conditions narrowed: so indexes are looked at again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from hypgen.codegen.layout.history_layout import fields as fields_of
from hypgen.codegen.layout.nodes import HistoryRead
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Node, children
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Int, Type


def unguarded(node: Node) -> Iterator[Node]:
    """Yield what is evaluated inside ``node`` whenever ``node`` is."""
    yield node
    certain: Iterator[Node]
    match node:
        case ir.If(condition=condition) | ir.IfDist(condition=condition):
            certain = iter((condition,))
        case ir.Binary(op="and" | "or", left=left):
            certain = iter((left,))
        case (
            ir.Quantified(condition=ir.Expr() as condition) | ir.UniformSet(condition=ir.Expr() as condition)
        ):
            certain = iter((condition,))
        case ir.Weighted(condition=condition, weight=weight):
            certain = iter((weight if condition is None else condition,))
        case _:
            certain = children(node)
    for child in certain:
        yield from unguarded(child)


@dataclass(frozen=True)
class _Signature:
    """The whole type of what a name stands for (None: of a record), and those of its indexes or arguments."""

    type: Type | None
    indices: tuple[Type, ...] = ()


class Hoisting:
    """Knows the whole range of everything that a model's expressions read."""

    def __init__(self, model: ir.Model) -> None:
        arrays: tuple[ir.Param | ir.ConstantArray, ...] = (*model.params, *model.tables)
        self.variables = {v.name: _Signature(v.type, v.indices) for v in model.variables}
        self.lets = {let.name: _Signature(let.dist.type, _types(let.binder)) for let in model.all_lets}
        self.kept = {f.key: _Signature(f.type, f.indices) for f in fields_of(model)}
        self.functions = {f.name: _Signature(f.type, _types(*f.formals)) for f in model.functions}
        self.constants = {a.name: _Signature(a.type, a.indices) for a in arrays}
        self.locals: dict[str, list[Type]] = {}
        self._declare(replace(model, tables=()))  # constants introduce none, and may be many

    def is_safe(self, node: Node) -> bool:
        """Return whether ``node`` is defined, and within the interval of its type, in every state."""
        match node:
            case ir.VariantArgument():
                return False
            case ir.Local(name=name):
                # A name that is not the model's is code generation's own, and of its whole type everywhere.
                return all(_covers(node.type, t) for t in self.locals.get(name, ()))
            case ir.StateRead(variable=name, indices=indices):
                whole = self.variables.get(name)
            case HistoryRead(field=name, indices=indices):
                whole = self.kept.get(name)
            case ir.LetRead(let=name, indices=indices):
                whole = self.lets.get(name)
            case ir.Call(function=name, arguments=indices):
                whole = self.functions.get(name)
            case ir.ParamRead(param=name, indices=indices) | ir.TableRead(table=name, indices=indices):
                whole = self.constants.get(name)
            case ir.FieldRead(record=record, field=field):
                whole, indices = _Signature(record.field_type(field)), ()
            case _:
                whole, indices = _Signature(node.type), ()
        return (
            whole is not None
            and _covers(node.type, whole.type)
            and all(_covers(t, i.type) for t, i in zip(whole.indices, indices, strict=True))
            and all(map(self.is_safe, children(node)))
        )

    def _declare(self, value: Any) -> None:
        """Enter the types of all locals that ``value`` introduces."""
        match value:
            case ir.Binder():
                self.locals.setdefault(value.name, []).append(value.type)
            case ir.LetIn() | ir.LetDist():
                self.locals.setdefault(value.name, []).append(value.value.type)
                self._declare_fields(value)
            case ir.DrawIn():
                self.locals.setdefault(value.name, []).append(value.law.type)
                self._declare_fields(value)
            case tuple():
                for entry in value:
                    self._declare(entry)
            case _ if is_dataclass(value) and not isinstance(value, Type | Span):
                self._declare_fields(value)

    def _declare_fields(self, value: Any) -> None:
        for item in fields(value):
            self._declare(getattr(value, item.name))


def _types(*binders: ir.Binder | None) -> tuple[Type, ...]:
    return tuple(b.type for b in binders if b is not None)


def _covers(t: Type | None, whole: Type | None) -> bool:
    if isinstance(t, Int) and isinstance(whole, Int):
        return t.low <= whole.low and whole.high <= t.high
    return True
