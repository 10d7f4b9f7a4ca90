# SPDX-License-Identifier: Apache-2.0
"""Parts of elements and the model: inits, updates, observations, rewards, conditions and bounds."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Literal

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check.constants.constants import shape
from hypgen.dsl.check.parts.array_values import array_of
from hypgen.dsl.check.parts.declarations import element_scope
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.scope.symbols import kind_of
from hypgen.dsl.check.scope.type_expressions import require_finite
from hypgen.dsl.check.scope.unit_checks import require_plain
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e02_names, e03_types, e04_variables, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, FLOAT, Float

ConditionKind = Literal["terminal", "legal", "success"]
CONDITIONS: tuple[ConditionKind, ...] = ("terminal", "legal", "success")
BOUNDS = ("upper", "lower", "tail")


def elements(program: Program) -> list[ast.Element]:
    """Return the model's elements, repeated names left out."""
    return [
        i
        for i in program.file.items
        if isinstance(i, ast.Element) and program.symbols.elements.get(i.name) is i
    ]


def assignments(program: Program) -> tuple[list[ir.Assign], list[ir.Assign]]:
    """Return all inits and all updates; reports variables that lack one or have two."""
    inits: list[ir.Assign] = []
    updates: list[ir.Assign] = []
    for owner in elements(program):
        seen: dict[tuple[type, str], ast.Item] = {}
        for member in owner.members:
            if isinstance(member, ast.Init | ast.Update):
                key = (type(member), member.name)
                if key in seen:
                    if f"{owner.name}.{member.name}" not in program.symbols.clashing:
                        program.report.add(_second(owner, member, seen[key]))
                    continue
                seen[key] = member
                found = program.report.attempt(partial(_assign, owner, member, program))
                if found is not None:
                    (inits if isinstance(member, ast.Init) else updates).append(found)
        for item in program.symbols.members[owner.name].values():
            if isinstance(item, ast.Variable):
                _require_assignments(owner, item, seen, program)
    return inits, updates


def _second(owner: ast.Element, member: ast.Init | ast.Update, first: ast.Item) -> Mistake:
    path, kind = f"{owner.name}.{member.name}", "init" if isinstance(member, ast.Init) else "update"
    return Mistake(e04_variables.second_assignment(path, kind, member.span, first.span))


def _require_assignments(
    owner: ast.Element, item: ast.Variable, seen: dict[tuple[type, str], ast.Item], program: Program
) -> None:
    path = f"{owner.name}.{item.name}"
    if (ast.Init, item.name) not in seen:
        program.report.add(Mistake(e04_variables.no_init(path, item.name, item.span)))
    update = seen.get((ast.Update, item.name))
    if update is None and not item.fixed:
        program.report.add(Mistake(e04_variables.no_update(path, item.name, item.span)))
    if update is not None and item.fixed:
        program.report.add(Mistake(e04_variables.update_of_fixed(path, update.span, item.span)))


def _not_own(name: str, program: Program) -> str:
    item = program.symbols.values.get(name)
    if isinstance(item, (ast.Const, ast.Param)):
        return f"'{name}' is {kind_of(item)}, which never changes: what changes is a variable"
    return f"an element assigns its own variables only; declare it here: hidden {name}: type"


def _assign(owner: ast.Element, member: ast.Init | ast.Update, program: Program) -> ir.Assign:
    own = program.symbols.members[owner.name]
    item = own.get(member.name)
    is_init = isinstance(member, ast.Init)
    if not isinstance(item, ast.Variable):
        known = [n for n, i in own.items() if isinstance(i, ast.Variable)]
        other = _not_own(member.name, program)
        raise Mistake(e04_variables.assigned_in_element(owner.name, member.name, known, other, member.span))
    variable = program.variable(owner.name, item)
    path = variable.name
    scope = element_scope(program, owner.name, Owner("init" if is_init else "update", path))
    binder = program.element(owner.name).binder
    family = () if binder is None else (binder,)
    indices = variable.indices[len(family) :]
    binders, dist = array_of(member.rhs, indices, scope, variable.type, member.name)
    site = ir.Site(f"init:{path}" if is_init else path)
    return ir.Assign(path, family + binders, dist, site, member.span)


def _owned(program: Program, kind: type[ast.Item]) -> Iterator[tuple[ast.Element | None, ast.Item]]:
    for item in program.file.items:
        if isinstance(item, kind):
            yield None, item
        if isinstance(item, ast.Element) and program.symbols.elements.get(item.name) is item:
            for member in item.members:
                if isinstance(member, kind):
                    yield item, member


def observations(program: Program) -> list[ir.Observation]:
    """Return all observations, in order."""
    found = []
    for owner, item in _owned(program, ast.Observe):
        assert isinstance(item, ast.Observe)
        name = item.name if owner is None else f"{owner.name}.{item.name}"
        if program.symbols.observations.get(name) is item:
            found.append(program.report.attempt(partial(_observation, owner, item, name, program)))
    return [o for o in found if o is not None]


def _observation(owner: ast.Element | None, item: ast.Observe, name: str, program: Program) -> ir.Observation:
    element = None if owner is None else owner.name
    scope = element_scope(program, element, Owner("observe", name))
    t, indices = shape(program.type_of(item.type))
    if not isinstance(t, Float):
        require_finite(t, item.type.span, "an observation", "a float, or a range such as 0 .. 100")
    own, dist = array_of(item.rhs, indices, scope, t, item.name)
    binder = None if element is None else program.element(element).binder
    binders = (() if binder is None else (binder,)) + own
    return ir.Observation(name, element, t, binders, dist, ir.Site(f"observe:{name}"), item.span)


def rewards(program: Program) -> list[ir.Reward]:
    """Return all reward terms, in order."""
    seen: dict[str, ast.Item] = {}
    found = []
    for owner, item in _owned(program, ast.Reward):
        assert isinstance(item, ast.Reward)
        name = item.name if owner is None else f"{owner.name}.{item.name}"
        if name in seen:
            program.report.add(Mistake(e02_names.duplicate(name, item.span, seen[name].span)))
            continue
        seen[name] = item
        found.append(program.report.attempt(partial(_reward, owner, item, name, program)))
    return [r for r in found if r is not None]


def _reward(owner: ast.Element | None, item: ast.Reward, name: str, program: Program) -> ir.Reward:
    element = None if owner is None else owner.name
    value = element_scope(program, element, Owner("reward", name)).check(item.value)
    if not operators.is_numeric(value.type):
        raise Mistake(e03_types.reward_not_a_number(value.type, item.value.span))
    require_plain(value, item.value.span, "a reward")
    binder = None if element is None else program.element(element).binder
    return ir.Reward(name, element, binder, value, item.span)


def invariants(program: Program) -> list[ir.Invariant]:
    """Return all invariants, named by their element and number."""
    found = []
    for number, (owner, item) in enumerate(_owned(program, ast.Invariant), 1):
        assert isinstance(item, ast.Invariant)
        name = f"{number}" if owner is None else f"{owner.name}.{number}"
        found.append(program.report.attempt(partial(_invariant, owner, item, name, program)))
    return [i for i in found if i is not None]


def _invariant(owner: ast.Element | None, item: ast.Invariant, name: str, program: Program) -> ir.Invariant:
    element = None if owner is None else owner.name
    scope = element_scope(program, element, Owner("invariant", name))
    value = check_as(item.condition, scope, BOOL, "an invariant")
    if operators.is_false(value):
        raise Mistake(e08_parts.false_invariant(item.condition.span))
    binder = None if element is None else program.element(element).binder
    return ir.Invariant(name, element, binder, value, item.span)


def condition(program: Program, kind: ConditionKind) -> ir.Expr | None:
    """Return what the ``kind when`` lines say together: for ``legal`` all, for others any; None without."""
    items = [i for i in program.file.items if isinstance(i, ast.Condition) and i.kind == kind]
    scope = Scope(program, owner=Owner(kind))
    what = f"the condition of '{kind} when'"
    parts = gather([partial(check_as, i.condition, scope, BOOL, what) for i in items])
    if not parts:
        return None
    result = parts[0]
    for part in parts[1:]:
        result = operators.both(result, part) if kind == "legal" else operators.either(result, part)
    return result


def bounds(program: Program) -> dict[str, ir.Expr]:
    """Return the declared bounds as floats, by name."""
    found: dict[str, ir.Expr] = {}
    seen: dict[str, ast.Bound] = {}
    for item in program.file.items:
        if not isinstance(item, ast.Bound):
            continue
        if item.name not in BOUNDS:
            program.report.add(Mistake(e08_parts.unknown_bound(item.name, BOUNDS, item.span)))
        elif item.name in seen:
            program.report.add(
                Mistake(e02_names.duplicate(f"bound {item.name}", item.span, seen[item.name].span))
            )
        else:
            seen[item.name] = item
            scope = Scope(program, owner=Owner("bound", item.name), history=item.name == "lower")
            value = program.report.attempt(partial(check_as, item.value, scope, FLOAT, f"bound {item.name}"))
            if value is not None:
                found[item.name] = value
    return found
