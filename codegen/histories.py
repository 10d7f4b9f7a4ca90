"""What the history keeps, as fields of a packed struct, and reads of it as reads of those fields.

``last(..)`` becomes a choice between a field and its first value, so that printing, tables and costs need to
know one kind of read only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.ir_walk import map_children
from hypgen.dsl.types import BOOL, Type

STARTED = "started"
ACTION = "last_action"


@dataclass(frozen=True)
class HistoryRead(ir.Expr):
    """A field of the history, as it is before the decision."""

    field: str
    indices: tuple[ir.Expr, ...] = ()


@dataclass(frozen=True)
class KeptField:
    """A field: its key among the model's names, the name that it would like, its type and indexes."""

    key: str
    name: str
    type: Type
    indices: tuple[Type, ...]


def memory_key(register: str) -> str:
    """Return the key of a register's field."""
    return f"memory:{register}"


def observation_key(observation: str) -> str:
    """Return the key of a kept observation's field."""
    return f"last:{observation}"


def fields(model: ir.Model) -> tuple[KeptField, ...]:
    """Return the fields of the model's history; none where it keeps nothing."""
    kept, action = model.history, model.action
    if kept.is_empty:
        return ()
    found = [KeptField(memory_key(r.name), r.name, r.type, r.indices) for r in kept.registers]
    for o in model.observations:
        if o.name in kept.observations:
            indices = tuple(b.type for b in o.binders)
            found.append(KeptField(observation_key(o.name), f"last_{o.name}", o.type, indices))
    if kept.action:
        found.append(KeptField(ACTION, f"last_{action.name}", action.type, action.indices))
    if kept.action or kept.observations:
        found.append(KeptField(STARTED, STARTED, BOOL, ()))
    return tuple(found)


def with_field_reads(model: ir.Model) -> ir.Model:
    """Return the model with every read of the history as a ``HistoryRead``."""
    policy, lower = model.policy, model.lower
    if policy is not None:
        lets = tuple(replace(x, dist=_read(x.dist)) for x in policy.lets)
        policy = replace(policy, dist=_read(policy.dist), lets=lets)
    registers = tuple(
        replace(r, update=replace(r.update, value=_read(r.update.value))) for r in model.history.registers
    )
    return replace(
        model,
        policy=policy,
        lower=None if lower is None else _read(lower),
        history=replace(model.history, registers=registers),
    )


def _read(node: Any) -> Any:
    node = map_children(node, _read)
    match node:
        case ir.MemoryRead(type_, register, indices):
            return HistoryRead(type_, memory_key(register), indices)
        case ir.LastObservation(type_, observation, indices, first):
            return _after_start(type_, HistoryRead(type_, observation_key(observation), indices), first)
        case ir.LastAction(type_, indices, first):
            return _after_start(type_, HistoryRead(type_, ACTION, indices), first)
    return node


def _after_start(type_: Type, read: ir.Expr, first: ir.Expr) -> ir.Expr:
    return ir.If(type_, HistoryRead(BOOL, STARTED), read, first)
