# SPDX-License-Identifier: Apache-2.0
"""``last(..)``: what the policy knows of the step before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hypgen.dsl import ir
from hypgen.dsl.analysis.uses import ReadKind, Use
from hypgen.dsl.check.constants.constants import shape
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.symbols import kind_of
from hypgen.dsl.check.terms.references import Reference, element_of, entry, record
from hypgen.dsl.messages import e02_names, e03_calls, e04_variables, e05_reads
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Type

_FORM = "last(observation, first) or last(action, first)"
Make = Callable[[tuple[ir.Expr, ...], ir.Expr], ir.Expr]


@dataclass(frozen=True)
class _Subject:
    """What ``last`` is asked for: its type, its indexes' types and how to read it."""

    name: str
    type: Type
    indices: tuple[Type, ...]
    use: ReadKind
    make: Make


def last(node: ast.Call, scope: Scope) -> ir.Expr:
    """Return the read of an observation or the action of the step before."""
    if len(node.arguments) != 2:
        raise Mistake(e03_calls.wrong_arguments_of_last(len(node.arguments), _FORM, node.span))
    if not scope.history:
        done = node.arguments[0]
        if isinstance(done, ast.Name) and done.name in scope.program.symbols.actions:
            raise Mistake(e05_reads.last_action_outside_policy(done.name, scope.kind, node.span))
        raise Mistake(e05_reads.history_outside_policy("last", scope.kind, node.span))
    if scope.primed:
        raise Mistake(e04_variables.next_last(node.span))
    what, first = node.arguments
    name, nodes = (what.operand, what.indices) if isinstance(what, ast.Index) else (what, ())
    subject = _subject(name, scope)
    start = check_as(first, scope, subject.type, f"what stands in for '{subject.name}' at the start")
    reference = Reference(subject.name, subject.indices, lambda indices: subject.make(indices, start))
    return record(
        entry(reference, nodes, what.span, scope), Use(subject.use, subject.name, False, node.span), scope
    )


def _subject(node: ast.Expr, scope: Scope) -> _Subject:
    program = scope.program
    match node:
        case ast.Name(_, name) if name not in scope.locals:
            item = program.symbols.values.get(name)
            if isinstance(item, ast.Action):
                action = program.action(item)
                make: Make = lambda i, first: ir.LastAction(action.type, i, first)  # noqa: E731
                return _Subject(name, action.type, action.indices, "last action", make)
            if name in program.symbols.observations:
                return _observation(name, (), scope)
        case ast.Member(_, operand, name):
            owner = element_of(operand, name, scope)
            if owner is not None and f"{owner[0]}.{name}" in program.symbols.observations:
                return _observation(f"{owner[0]}.{name}", owner[1], scope)
    raise _not_seen(node, scope)


def _observation(path: str, member: tuple[ir.Expr, ...], scope: Scope) -> _Subject:
    t, indices = shape(scope.program.type_of(scope.program.symbols.observations[path].type))

    def make(own: tuple[ir.Expr, ...], first: ir.Expr) -> ir.Expr:
        return ir.LastObservation(t, path, (*member, *own), first)

    return _Subject(path, t, indices, "last", make)


def _as_read(scope: Scope) -> Callable[[str], str]:
    """Return how an observation's path is written: ``machine[m].hum`` of a family."""

    def written(path: str) -> str:
        element, _, name = path.partition(".")  # or a record of floats and its field
        is_element = name and element in scope.program.symbols.elements
        binder = scope.program.element(element).binder if is_element else None
        return path if binder is None else f"{element}[{binder.name}].{name}"

    return written


def _not_seen(node: ast.Expr, scope: Scope) -> Mistake:
    symbols = scope.program.symbols
    if not isinstance(node, ast.Name | ast.Member):
        return Mistake(e02_names.last_of_nameless(_FORM, node.span))
    name = node.name
    item: ast.Item | None = symbols.policy.get(name) or symbols.values.get(name)
    if isinstance(node, ast.Member) and (owner := element_of(node.operand, name, scope)) is not None:
        item = symbols.members[owner[0]].get(name)
        name = f"{owner[0]}.{name}"
    kind = symbols.other_kind(name) if item is None else kind_of(item)
    if kind is not None:
        return Mistake(e02_names.last_of_other(name, kind, _FORM, node.span))
    known = [*map(_as_read(scope), symbols.observations), *symbols.actions]
    return Mistake(e02_names.last_of_unknown(name, known, _FORM, node.span))
