"""Which expressions may be evaluated outside of the conditions that stand around them.

Conditions narrow the intervals of what is read where they hold: ``if x > 6 then log(x - 5) else 0`` needs a
table of two entries, whose index is out of range wherever the condition fails.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from hypgen.codegen.histories import HistoryRead
from hypgen.codegen.histories import fields as fields_of
from hypgen.dsl import ir
from hypgen.dsl.ir_walk import Node, children
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


class Hoisting:
    """Knows the whole range of everything that a model's expressions read."""

    def __init__(self, model: ir.Model) -> None:
        self.variables = {v.name: v.type for v in model.variables}
        self.lets = {let.name: let.dist.type for let in model.all_lets}
        self.kept = {f.key: f.type for f in fields_of(model)}
        self.functions = {f.name: f.type for f in model.functions}
        self.constants = {p.name: p.type for p in model.params} | {t.name: t.type for t in model.tables}
        self.locals: dict[str, list[Type]] = {}
        self._declare(model)

    def is_safe(self, node: Node) -> bool:
        """Return whether ``node`` is defined, and within the interval of its type, in every state."""
        match node:
            case ir.VariantArgument():
                return False
            case ir.Local(name=name):
                # A name that is not the model's is code generation's own, and of its whole type everywhere.
                return all(_covers(node.type, t) for t in self.locals.get(name, ()))
            case ir.StateRead(variable=name):
                whole = self.variables.get(name)
            case HistoryRead(field=name):
                whole = self.kept.get(name)
            case ir.LetRead(let=name):
                whole = self.lets.get(name)
            case ir.Call(function=name):
                whole = self.functions.get(name)
            case ir.ParamRead(param=name) | ir.TableRead(table=name):
                whole = self.constants.get(name)
            case ir.FieldRead(record=record, field=field):
                whole = record.field_type(field)
            case _:
                whole = node.type
        return whole is not None and _covers(node.type, whole) and all(map(self.is_safe, children(node)))

    def _declare(self, value: Any) -> None:
        """Enter the types of all locals that ``value`` introduces."""
        match value:
            case ir.Binder():
                self.locals.setdefault(value.name, []).append(value.type)
            case ir.LetIn() | ir.LetDist():
                self.locals.setdefault(value.name, []).append(value.value.type)
                self._declare_fields(value)
            case HistoryRead():
                self._declare_fields(value)
            case tuple():
                for entry in value:
                    self._declare(entry)
            case _ if type(value).__module__ in (ir.__name__, ir.Expr.__module__):
                self._declare_fields(value)

    def _declare_fields(self, value: Any) -> None:
        for item in fields(value):
            self._declare(getattr(value, item.name))


def _covers(t: Type, whole: Type) -> bool:
    if isinstance(t, Int) and isinstance(whole, Int):
        return t.low <= whole.low and whole.high <= t.high
    return True
