# SPDX-License-Identifier: Apache-2.0
"""All that a model file says: its declarations, and the parts that say what elements and the model do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TypeVar

from hypgen.dsl import ir
from hypgen.dsl.check.constants import settings
from hypgen.dsl.check.parts import drawings, model_parts, policies
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.check.scope.symbols import Global, StateMember
from hypgen.dsl.messages import e08_parts
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Enum, Record, is_finite

T = TypeVar("T")


@dataclass(frozen=True)
class Declarations:
    """The checked declarations, each kind in the order of the text; those with mistakes are left out."""

    enums: tuple[Enum, ...] = ()
    records: tuple[Record, ...] = ()
    params: tuple[ir.Param, ...] = ()
    tables: tuple[ir.ConstantArray, ...] = ()
    elements: tuple[ir.Element, ...] = ()
    variables: tuple[ir.Variable, ...] = ()
    lets: tuple[ir.Let, ...] = ()
    functions: tuple[ir.Function, ...] = ()


@dataclass(frozen=True)
class Parts:
    """The checked parts, each kind in the order of the text; those with mistakes are left out.

    ``action`` and ``discount`` are None where they have mistakes. The conditions are None where the model
    has none, too.
    """

    action: ir.Action | None = None
    discount: float | None = None
    horizon: int | None = None
    inits: tuple[ir.Assign, ...] = ()
    updates: tuple[ir.Assign, ...] = ()
    observations: tuple[ir.Observation, ...] = ()
    rewards: tuple[ir.Reward, ...] = ()
    terminal: ir.Expr | None = None
    legal: ir.Expr | None = None
    success: ir.Expr | None = None
    policy: ir.Policy | None = None
    bounds: Mapping[str, ir.Expr] = field(default_factory=dict)
    history: ir.History = ir.History()
    invariants: tuple[ir.Invariant, ...] = ()
    drawings: tuple[ir.Drawing, ...] = ()


def all_declarations(program: Program) -> Declarations:
    """Return all declarations, checked; reports the mistakes of each."""
    found = list(_each(program))
    return Declarations(
        enums=tuple(dict.fromkeys(_of(Enum, found))),  # a type that stands for an enum gives it again
        records=tuple(dict.fromkeys(r for r in _of(Record, found) if is_finite(r))),
        params=_of(ir.Param, found),
        tables=_of(ir.ConstantArray, found),
        elements=_of(ir.Element, found),
        variables=_of(ir.Variable, found),
        lets=_of(ir.Let, found),
        functions=_of(ir.Function, found),
    )


def _each(program: Program) -> Iterator[object]:
    """Yield what each declaration gives, in the order of the text, an element before its members."""
    attempt = program.report.attempt
    for item in program.symbols.declared:
        yield (found := attempt(partial(_declaration, item, program)))
        if isinstance(item, ast.Element) and found is not None:
            for member in program.symbols.members[item.name].values():
                yield attempt(partial(_member, item.name, member, program))


def _declaration(item: Global, program: Program) -> object:
    """Return what a declaration gives: a type, a const, an IR node; None where uses alone give something."""
    match item:
        case ast.TypeAlias() | ast.EnumDecl() | ast.RecordDecl():
            return program.named_type(item)
        case ast.Const():
            return program.const(item)
        case ast.Param():
            return program.param(item)
        case ast.Function(rhs=ast.Rhs(draw=True)):
            return program.named_distribution(item)
        case ast.Function(_, name) if name not in program.recursive:
            return program.function(item)
        case ast.Element(_, name):
            return program.element(name)
    return None


def _member(element: str, member: StateMember, program: Program) -> ir.Variable | ir.Let:
    if isinstance(member, ast.Variable):
        return program.variable(element, member)
    return program.let(element, member)


def _of(kind: type[T], found: Iterable[object]) -> tuple[T, ...]:
    return tuple(x for x in found if isinstance(x, kind))


def all_parts(program: Program) -> Parts:
    """Return all parts, checked; reports the mistakes of each."""
    attempt = program.report.attempt
    action = attempt(partial(_action, program))
    discount = attempt(partial(program.discount, program.file.span))
    horizon = attempt(partial(settings.horizon, program))
    inits, updates = model_parts.assignments(program)
    observations = model_parts.observations(program)
    rewards = model_parts.rewards(program)
    terminal = attempt(partial(model_parts.condition, program, "terminal"))
    legal = attempt(partial(model_parts.condition, program, "legal"))
    success = attempt(partial(model_parts.condition, program, "success"))
    policy = None if action is None else attempt(partial(policies.policy, program, action))
    bounds = model_parts.bounds(program)
    history = policies.history(program, observations)
    return Parts(
        action=action,
        discount=discount,
        horizon=horizon,
        inits=tuple(inits),
        updates=tuple(updates),
        observations=tuple(observations),
        rewards=tuple(rewards),
        terminal=terminal,
        legal=legal,
        success=success,
        policy=policy,
        bounds=bounds,
        history=history,
        invariants=tuple(model_parts.invariants(program)),
        drawings=tuple(drawings.drawings(program)),
    )


def _action(program: Program) -> ir.Action:
    items = [i for i in program.file.items if isinstance(i, ast.Action)]
    if not items:
        raise Mistake(e08_parts.no_action(program.file.span))
    if len(items) > 1:
        raise Mistake(e08_parts.second_action(items[1].span, items[0].span))
    return program.action(items[0])
