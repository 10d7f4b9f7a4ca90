# SPDX-License-Identifier: Apache-2.0
"""The default policy: what it remembers, what it names, what it chooses."""

from __future__ import annotations

from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check.constants.constants import shape
from hypgen.dsl.check.parts.array_values import array_of
from hypgen.dsl.check.parts.declarations import let_of
from hypgen.dsl.check.scope.draw_syntax import is_draw, refuse_fields
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.scope.type_expressions import length, require_finite
from hypgen.dsl.messages import e02_names, e04_variables, e05_reads, e06_ranges, e08_parts
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT32_MAX, Float, Type

OWNER = Owner("policy")


def policy(program: Program, action: ir.Action) -> ir.Policy | None:
    """Return the default policy, None if there is none."""
    item = _item(program)
    if item is None:
        return None
    found = [program.report.attempt(partial(program.policy_let, x)) for x in _lets(program)]
    lets = tuple(x for x in found if x is not None)
    scope = Scope(program, owner=OWNER, history=True)
    binders, dist = array_of(item.rhs, action.indices, scope, action.type, action.name)
    return ir.Policy(binders, dist, ir.Site("policy:default"), item.span, lets)


def _item(program: Program) -> ast.Policy | None:
    items = [i for i in program.file.items if isinstance(i, ast.Policy)]
    for item in items:
        if item.name != "default":
            raise Mistake(e08_parts.unknown_policy(item.name, item.span))
    if len(items) > 1:
        raise Mistake(e02_names.duplicate("policy default", items[1].span, items[0].span))
    return items[0] if items else None


def _lets(program: Program) -> list[ast.Let]:
    return [m for m in program.symbols.policy.values() if isinstance(m, ast.Let)]


def _memory(program: Program) -> list[ast.Memory]:
    return [m for m in program.symbols.policy.values() if isinstance(m, ast.Memory)]


def readers(program: Program) -> list[Owner]:
    """Return the policy's declarations, none of which may read everything."""
    lets = [Owner("policy let", f"policy.{x.name}") for x in _lets(program)]
    memory = [
        o for m in _memory(program) for o in (Owner("first memory", m.name), Owner("next memory", m.name))
    ]
    return [OWNER, *lets, *memory, *(b.owner for b in program.beliefs)]


def let(item: ast.Let, program: Program) -> ir.Let:
    """Return a let of the policy."""
    path = f"policy.{item.name}"
    scope = Scope(program, owner=Owner("policy let", path), history=True)
    return let_of(item, path, scope, ir.Site(f"policy:{item.name}"))


def memory(item: ast.Memory, program: Program) -> tuple[Type, tuple[Type, ...]]:
    """Return the types of a register's entries and of its indexes."""
    t, indices = shape(program.type_of(item.type))
    if not isinstance(t, Float):
        require_finite(t, item.type.span, "memory", "a float, or a range such as 0 .. 100")
    if length(indices) > INT32_MAX:
        raise Mistake(e06_ranges.long_memory(item.type.span))
    return t, indices


def history(program: Program, observations: list[ir.Observation]) -> ir.History:
    """Return what is kept of the past: the registers, and what is read with ``last``."""
    updates = _updates(program)
    found = [program.report.attempt(partial(_register, m, updates, program)) for m in _memory(program)]
    uses = [u for owner in [*readers(program), Owner("bound", "lower")] for u in program.uses.of(owner)]
    seen = {u.name for u in uses if u.kind == "last"}
    return ir.History(
        tuple(r for r in found if r is not None),
        tuple(o.name for o in observations if o.name in seen),
        any(u.kind == "last action" for u in uses),
    )


def _updates(program: Program) -> dict[str, ast.Update]:
    """Return the registers' updates by name; reports those of nothing and second ones."""
    found: dict[str, ast.Update] = {}
    items = [m for i in program.file.items if isinstance(i, ast.Policy) for m in i.members]
    registers = [m.name for m in items if isinstance(m, ast.Memory)]  # those with a wrong name too
    for item in items:
        if not isinstance(item, ast.Update):
            continue
        if item.name not in registers:
            program.report.add(Mistake(e04_variables.assigned_in_policy(item.name, registers, item.span)))
        elif item.name in found:
            first = found[item.name].span
            program.report.add(Mistake(e04_variables.second_update_of_memory(item.name, item.span, first)))
        else:
            found[item.name] = item
    return found


def _register(item: ast.Memory, updates: dict[str, ast.Update], program: Program) -> ir.Register:
    t, indices = program.memory(item)
    update = updates.get(item.name)
    if update is None:
        kept = _kept(item.name, indices)
        raise Mistake(e04_variables.no_update_of_memory(item.name, kept, item.span))
    first_scope = Scope(program, owner=Owner("first memory", item.name))
    scope = Scope(program, owner=Owner("next memory", item.name), history=True)
    first = ast.Rhs(item.first.span, False, item.first)
    return ir.Register(
        item.name,
        t,
        indices,
        _first(first, indices, first_scope, t, item.name),
        _entries(update.rhs, indices, scope, t, item.name),
        item.span,
    )


def _kept(name: str, indices: tuple[Type, ...]) -> str:
    if not indices:
        return f"{name}' = {name}"
    places = list(zip("ijklmnpqrstuvw", indices, strict=False))
    binders = ", ".join(f"{i} in {t}" for i, t in places)
    return f"{name}' = [{binders}: {name}[{', '.join(i for i, _ in places)}]]"


def _first(rhs: ast.Rhs, indices: tuple[Type, ...], scope: Scope, t: Type, name: str) -> ir.Entries:
    """Return what a register holds at first; one value that is not an array stands for all entries."""
    if not indices or isinstance(rhs.expr, ast.Comprehension | ast.ArrayLiteral):
        return _entries(rhs, indices, scope, t, name)
    _refuse_draw(rhs, scope, t, name)
    value = check_as(rhs.expr, scope, t, f"'{name}'")
    binders: list[ir.Binder] = []
    for index in indices:
        binders.append(ir.Binder(scope.fresh("i"), index))
        scope = scope.hide(binders[-1].name, ir.Local(index, binders[-1].name))
    return ir.Entries(tuple(binders), value)


def _entries(rhs: ast.Rhs, indices: tuple[Type, ...], scope: Scope, t: Type, name: str) -> ir.Entries:
    _refuse_draw(rhs, scope, t, name)
    binders, dist = array_of(rhs, indices, scope, t, name)
    assert isinstance(dist, ir.Certain)
    return ir.Entries(binders, dist.value)


def _refuse_draw(rhs: ast.Rhs, scope: Scope, t: Type, name: str) -> None:
    if rhs.draw or is_draw(rhs.expr, scope):
        refuse_fields(rhs.expr, t)
        raise Mistake(e05_reads.draw_in_memory(name, rhs.span))
