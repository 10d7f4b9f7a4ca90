# SPDX-License-Identifier: Apache-2.0
"""The action, elements, variables, lets and functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check.constants.constants import shape
from hypgen.dsl.check.draws.distributions import right_side
from hypgen.dsl.check.scope.fit_type import check_as, fit
from hypgen.dsl.check.scope.scope import Falling, Program, Scope
from hypgen.dsl.check.scope.type_expressions import length, require_finite, require_length, scalar_type
from hypgen.dsl.ir.operators import integer, retyped
from hypgen.dsl.messages import e06_ranges
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import INT, INT32_MAX, PROB, Float, Int, Type, size_of


def action(item: ast.Action, program: Program) -> ir.Action:
    """Return the action, whose joint values are counted by an int."""
    t, indices = shape(program.type_of(item.type))
    require_finite(t, item.type.span, "the action")
    if size_of(t) ** min(length(indices), 32) > INT32_MAX:
        raise Mistake(e06_ranges.many_actions(item.span))
    return ir.Action(item.name, t, indices, item.span)


def element(item: ast.Element, program: Program) -> ir.Element:
    """Return an element."""
    if item.binder is None:
        return ir.Element(item.name, None, item.span)
    program.symbols.refuse_shadow(item.binder.name, None, item.binder.span)
    t = program.type_of(item.binder.type)
    require_finite(t, item.binder.type.span, "a family's index")
    return ir.Element(item.name, ir.Binder(item.binder.name, t), item.span)


def element_scope(program: Program, name: str | None, owner: Owner | None) -> Scope:
    """Return the scope of an element's members, or of the top level."""
    binder = None if name is None else program.element(name).binder
    own: dict[str, ir.Expr] = {} if binder is None else {binder.name: ir.Local(binder.type, binder.name)}
    return Scope(program, owner=owner, element=name, locals=own)


def variable(owner: str, item: ast.Variable, program: Program) -> ir.Variable:
    """Return a variable of the element ``owner``."""
    binder = program.element(owner).binder
    t, own = shape(program.type_of(item.type))
    if not isinstance(t, Float):
        require_finite(t, item.type.span, "a variable", "a float, or a range such as 0 .. 100")
    indices = (() if binder is None else (binder.type,)) + own
    require_length(indices, item.type.span)
    return ir.Variable(f"{owner}.{item.name}", owner, t, indices, item.visible, item.fixed, item.span)


def let(owner: str, item: ast.Let, program: Program) -> ir.Let:
    """Return a let of the element ``owner``."""
    path = f"{owner}.{item.name}"
    scope = element_scope(program, owner, Owner("let", path))
    return let_of(item, path, scope, ir.Site(f"let:{path}"), program.element(owner).binder)


def let_of(item: ast.Let, path: str, scope: Scope, site: ir.Site, binder: ir.Binder | None = None) -> ir.Let:
    """Return the let ``path`` that ``item`` declares, checked in ``scope``."""
    target = None if item.type is None else scalar_type(item.type, scope.program)
    dist = right_side(item.rhs, scope, target, f"'{item.name}'")
    if isinstance(dist, ir.Certain):
        dist = ir.Certain(dist.value.type, dist.value)
    return ir.Let(path, path.partition(".")[0], binder, dist, site, item.span)


def formals(item: ast.Function, program: Program) -> tuple[ir.Binder, ...]:
    """Return a function's formals."""
    types = gather([partial(scalar_type, f.type, program) for f in item.formals])
    return tuple(ir.Binder(f.name, t) for f, t in zip(item.formals, types, strict=True))


def function(item: ast.Function, program: Program) -> ir.Function:
    """Return a function; its type's interval is what the body can reach."""
    binders = program.formals(item)
    open_ints = any(b.type == INT for b in binders)
    scope = Scope(program, owner=Owner("function", item.name), open_ints=open_ints)
    for field, binder in zip(item.formals, binders, strict=True):
        scope = scope.bind(field.name, ir.Local(binder.type, binder.name), field.span)
    declared = scalar_type(item.type, program)
    body = check_as(item.rhs.expr, scope, declared, f"the value of '{item.name}'")
    return ir.Function(item.name, binders, _reached(declared, body), body, item.span)


def copy(name: str, item: ast.Function, frames: tuple[Falling, ...], program: Program) -> ir.Function:
    """Return a recursive function under ``name``, with the constants of the last of ``frames`` filled in."""
    constants = frames[-1].constants
    binders = program.formals(item)
    open_ints = any(b.type == INT and b.name not in constants for b in binders)
    scope = Scope(program, owner=Owner("function", name), unrolling=frames, open_ints=open_ints)
    for field, binder in zip(item.formals, binders, strict=True):
        given = constants.get(binder.name)
        value = ir.Local(binder.type, binder.name) if given is None else integer(given)
        scope = scope.bind(field.name, value, field.span)
    declared = scalar_type(item.type, program)
    body = check_as(item.rhs.expr, scope, declared, f"the value of '{item.name}'")
    rest = tuple(b for b in binders if b.name not in constants)
    return ir.Function(name, rest, _reached(declared, body), body, item.span)


def _reached(declared: Type, body: ir.Expr) -> Type:
    return body.type if isinstance(declared, Int | Float) and declared != PROB else declared


def follow_call(item: ast.Function, arguments: list[ir.Expr], scope: Scope) -> ir.Expr:
    """Return the value of a call of ``item`` where ``scope`` evaluates."""
    program = scope.program
    if item.name not in program.recursive:
        program.function(item)  # reports what is wrong with it by itself
    names = [f.name for f in item.formals]
    inner = _followed(scope, None, dict(zip(names, arguments, strict=True)))
    declared = scalar_type(item.type, program)
    body = check_as(item.rhs.expr, inner, declared, f"the value of '{item.name}'")
    return retyped(body, PROB) if declared == PROB else body


def follow_let(owner: str, item: ast.Let, member: tuple[ir.Expr, ...], scope: Scope) -> ir.Expr:
    """Return the value of a let that does not draw where ``scope`` evaluates."""
    binder = scope.program.element(owner).binder
    inner = _followed(scope, owner, {} if binder is None else {binder.name: member[0]})
    e = inner.check(item.rhs.expr)
    return e if item.type is None else fit(e, scalar_type(item.type, scope.program), item.rhs.span)


def _followed(scope: Scope, owner: str | None, bound: Mapping[str, ir.Expr]) -> Scope:
    """Return the scope of a body with names standing for values of the caller.

    What is no constant becomes a local of its own, lest the caller's locals be taken for the body's.
    """
    opaque = {
        name: value if isinstance(value, ir.Const) else ir.Local(value.type, f"{name} of the call")
        for name, value in bound.items()
    }
    return replace(scope, element=owner, locals=opaque, facts={}, primed=False)
