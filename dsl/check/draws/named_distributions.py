# SPDX-License-Identifier: Apache-2.0
"""``fn name(..): T ~ D``: a distribution with a name, written out where it is drawn from."""

from __future__ import annotations

from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Use
from hypgen.dsl.check.draws.fit_distribution import fitted
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.let_bindings import let_dist
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.scope.type_expressions import scalar_type
from hypgen.dsl.ir.walk import rename_bound
from hypgen.dsl.messages import e03_calls
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Type


def declared(item: ast.Function, program: Program) -> ir.Dist:
    """Return the distribution that a function names, over its formals as locals; notes what it reads."""
    scope = Scope(program, owner=Owner("function", item.name))
    for field, binder in zip(item.formals, program.formals(item), strict=True):
        scope = scope.bind(field.name, ir.Local(binder.type, binder.name), field.span)
    return _body(item, scope)


def _body(item: ast.Function, scope: Scope) -> ir.Dist:
    return scope.draw(item.rhs.expr, scalar_type(item.type, scope.program), f"what '{item.name}' draws")


def inlined(node: ast.Call, item: ast.Function, scope: Scope, target: Type | None, what: str) -> ir.Dist:
    """Return what a call of a named distribution draws; the draw is the caller's."""
    program = scope.program
    formals = program.formals(item)
    program.named_distribution(item)  # reports what is wrong with it by itself, recursion included
    if len(node.arguments) != len(formals):
        form = f"{item.name}({', '.join(f'{f.name}: {f.type}' for f in formals)})"
        has = len(node.arguments)
        raise Mistake(e03_calls.wrong_arguments(item.name, len(formals), has, form, node.span))
    arguments = gather(
        [
            partial(check_as, n, scope, f.type, f"argument '{f.name}'")
            for n, f in zip(node.arguments, formals, strict=True)
        ]
    )
    if scope.owner is not None:
        program.uses.add(scope.owner, Use("function", item.name, scope.primed, node.span))
    # No local of the model has such a name, so that none of the caller's is captured.
    suffix = f"%{program.number_call()}"
    bound: dict[str, ir.Expr] = {
        f.name: e if isinstance(e, ir.Const) else ir.Local(f.type, f.name + suffix)
        for f, e in zip(formals, arguments, strict=True)
    }
    dist = rename_bound(_body(item, Scope(program, locals=bound, primed=scope.primed)), suffix)
    for formal, argument in zip(formals, arguments, strict=True):
        dist = let_dist(formal.name + suffix, argument, dist)
    return fitted(dist, target, node.span, what)
