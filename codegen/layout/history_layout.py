# SPDX-License-Identifier: Apache-2.0
"""The history as fields of a packed struct, and reads of it as reads of those fields.

``last(..)`` becomes a choice between a field and its first value, so that printing, tables and costs need to
know one kind of read only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from hypgen.codegen.layout.nodes import BeliefCall, HistoryRead
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Node, free_locals, map_children, walk
from hypgen.dsl.types import BOOL, FLOAT, Int, Type

STARTED = "started"
ACTION = "last_action"


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


def belief_key(element: str) -> str:
    """Return the key of the field with a factor's posterior."""
    return f"belief:{element}"


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
    for factor in model.factors:
        if factor.element in kept.beliefs:
            last = factor.size - 1 if factor.exact else 1  # mean and deviation
            values = () if factor.size == 2 else (Int(0, last),)
            members = () if factor.binder is None else (factor.binder.type,)
            name = f"belief_{factor.element}"
            found.append(KeptField(belief_key(factor.element), name, FLOAT, (*members, *values)))
    if kept.action:
        found.append(KeptField(ACTION, f"last_{action.name}", action.type, action.indices))
    if kept.action or kept.observations:
        found.append(KeptField(STARTED, STARTED, BOOL, ()))
    return tuple(found)


def with_field_reads(model: ir.Model) -> ir.Model:
    """Return the model with every read of the history as a ``HistoryRead``."""
    policy, lower, read = model.policy, model.lower, partial(_read, factors=model.factors)
    if policy is not None:
        lets = tuple(replace(x, dist=read(x.dist)) for x in policy.lets)
        policy = replace(policy, dist=read(policy.dist), lets=lets)
    registers = tuple(
        replace(r, update=replace(r.update, value=read(r.update.value))) for r in model.history.registers
    )
    return replace(
        model,
        policy=policy,
        lower=None if lower is None else read(lower),
        history=replace(model.history, registers=registers),
    )


def belief_reads(model: ir.Model) -> dict[int, ir.BeliefRead]:
    """Return the beliefs that take a function, by number, with reads of fields inside."""
    policy = model.policy
    nodes: list[Node] = [r.update.value for r in model.history.registers]
    nodes += [] if policy is None else [policy.dist, *(x.dist for x in policy.lets)]
    nodes += [] if model.lower is None else [model.lower]
    reads = [e for node in nodes for e in walk(node) if isinstance(e, ir.BeliefRead)]
    return {
        e.number: map_children(e, partial(_read, factors=model.factors))
        for e in reads
        if not any(f.holds(e) for f in model.factors)
    }


def _read(node: Any, factors: Sequence[ir.Factor]) -> Any:
    node = map_children(node, partial(_read, factors=factors))
    match node:
        case ir.MemoryRead(type_, register, indices):
            return HistoryRead(type_, memory_key(register), indices)
        case ir.LastObservation(type_, observation, indices, first):
            return _after_start(type_, HistoryRead(type_, observation_key(observation), indices), first)
        case ir.LastAction(type_, indices, first):
            return _after_start(type_, HistoryRead(type_, ACTION, indices), first)
        case ir.BeliefRead(type_, number, element, index, _, deviation):
            factor = next((f for f in factors if f.holds(node)), None)
            if factor is None:
                return BeliefCall(type_, number, locals_in(node))
            member = () if index is None else (index,)
            entry = () if factor.moments is None else (ir.Const(Int(0, 1), int(deviation)),)
            return HistoryRead(type_, belief_key(element), (*member, *entry))
    return node


def locals_in(node: Node) -> tuple[ir.Local, ...]:
    """Return the locals that ``node`` reads and does not introduce, by name."""
    free = free_locals(node)
    found = {e.name: e for e in walk(node) if isinstance(e, ir.Local) and e.name in free}
    return tuple(found[name] for name in sorted(found))


def _after_start(type_: Type, read: ir.Expr, first: ir.Expr) -> ir.Expr:
    return ir.If(type_, HistoryRead(BOOL, STARTED), read, first)
