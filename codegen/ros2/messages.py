# SPDX-License-Identifier: Apache-2.0
"""Messages of a model's enums and records, and the fields of what is seen and visible."""

from __future__ import annotations

import json
from collections.abc import Iterable

from hypgen.codegen.ros2.package_data import EnumMessage, Field, RecordMessage
from hypgen.codegen.ros2.ros_names import RosScope, header
from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Enum, Float, Record, Type, length_of, low_of, size_of

OWN_MESSAGES = ("Belief", "Decision", "Observation", "Plan", "Reset", "Status")  # that every model has


class Messages:
    """The messages that the fields of a model need, each once; a field's type names one of them."""

    def __init__(self, model: ir.Model) -> None:
        self.enums: list[EnumMessage] = []
        self.records: list[RecordMessage] = []
        self._scope = RosScope({header(name) for name in OWN_MESSAGES})
        self._names: dict[str, str] = {}
        scope = RosScope({"action"})
        self.seen = tuple(self._field(k.name, k.type, k.indices, scope) for k in model.key)
        scope = RosScope({"episode", "visible_given"})
        visible = [v for v in model.variables if v.visible]
        self.visible = tuple(self._field(v.name, v.type, v.indices, scope) for v in visible)
        self.action = self._action(model.action)

    def _field(self, name: str, type_: Type, indices: tuple[Type, ...], scope: RosScope) -> Field:
        length = f"[{length_of(indices)}]" if indices else ""
        return Field(described(name, type_, indices), self._type(type_) + length, scope.field(name))

    def _type(self, type_: Type) -> str:
        """Return the type of a field, whose message is made with it."""
        match type_:
            case Bool():
                return "bool"
            case Float():
                return "float32"
            case Enum() | Record():
                return self._names.get(type_.name) or self._message(type_)
        return "int32"

    def _message(self, type_: Enum | Record) -> str:
        if isinstance(type_, Enum):
            name = self._names[type_.name] = self._scope.message(type_.name)
            title = f"A code of the model's enum {type_.name}."
            self.enums.append(EnumMessage(name, header(name), title, tuple(_constants(type_))))
            return name
        scope = RosScope()
        fields = [Field(f"{f}: {t}", self._type(t), scope.field(f)) for f, t in type_.fields]
        name = self._names[type_.name] = self._scope.message(type_.name)
        title = f"A value of the model's record {type_.name}."
        digits = tuple(
            f"value_of(from.{field.name}, error), {low_of(t)}, {low_of(t) + size_of(t) - 1}, "
            f"{json.dumps(f'{type_.name}.{f}')}"
            for field, (f, t) in zip(fields, type_.fields, strict=True)
        )
        self.records.append(RecordMessage(name, header(name), title, tuple(fields), digits))
        return name

    def _action(self, action: ir.Action) -> str:
        """Return what an action's number is; an enum of actions is a message, for its constants."""
        if action.indices:
            shape = described(action.name, action.type, action.indices)
            return f"the number of the joint action {shape}; the first component counts most"
        if isinstance(action.type, Enum):
            return f"the number of the action, a constant of {self._type(action.type)}"
        return f"the number of the action {action.name}: {action.type}; the first is 0"


def described(name: str, type_: Type, indices: tuple[Type, ...]) -> str:
    """Return a declaration of the model's as a comment has it."""
    by_rows = ", row by row" if len(indices) > 1 else ""
    shape = f"[{', '.join(map(str, indices))}]" if indices else ""
    return f"{name}{shape}: {type_}{by_rows}"


def _constants(enum: Enum) -> Iterable[str]:
    scope = RosScope()
    for variant in enum.variants:
        comment = ""
        if variant.argument is not None:
            low, size = low_of(variant.argument), size_of(variant.argument)
            comment = f"  # the first of {size}, of {variant.name}({low})"
        yield f"int32 {scope.constant(variant.name)}={enum.offsets[variant.name]}{comment}"
