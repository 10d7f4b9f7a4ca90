"""Consts and params: values that are known when the model is compiled, settings applied."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import prod
from typing import TYPE_CHECKING

from hypgen.dsl import ir
from hypgen.dsl.check.constants import constant_entries, distances, value_lists
from hypgen.dsl.check.scope import grid_literals
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.terms.quantifiers import bind_all, bind_types, values_of
from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.messages.report import Mistake, gather, mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Array, Type, flat_indices, size_of

if TYPE_CHECKING:
    from hypgen.dsl.check.program import Program

_MAX_ENTRIES = 1 << 20  # a second or more


def shape(t: Type) -> tuple[Type, tuple[Type, ...]]:
    """Return an array's element and index types; a scalar has no index."""
    return (t.element, t.indices) if isinstance(t, Array) else (t, ())


def const(item: ast.Const, program: Program) -> ir.Const | ir.ConstantArray:
    """Return the value of a const."""
    element, indices = shape(program.type_of(item.type))
    node = program.overrides.get(item.name, item.value)
    scope = Scope(program, evaluate=True, constant=True)
    if not indices:
        return constant_entries.scalar(node, scope, element, f"'{item.name}'")
    values = entries_of(node, scope, element, indices, item.name)
    return ir.ConstantArray(item.name, element, indices, values, item.span)


def param(item: ast.Param, program: Program) -> ir.Param:
    """Return a param with its default, if it has one."""
    element, indices = shape(program.type_of(item.type))
    node = program.overrides.get(item.name, item.default)
    default = None
    if node is not None:
        scope = Scope(program, evaluate=True, constant=True)
        default = entries_of(node, scope, element, indices, item.name)
    return ir.Param(item.name, element, indices, default, item.span)


def entries_of(
    node: ast.Expr, scope: Scope, element: Type, indices: tuple[Type, ...], name: str
) -> tuple[Value, ...]:
    """Return the entries of an array written as ``node``, row-major."""
    if not indices:
        if isinstance(node, ast.ArrayLiteral | ast.Comprehension):
            raise _wrong_shape(
                name, "takes one value here, not an array", node.span, f"a value of type {element}"
            )
        return (constant_entries.scalar(node, scope, element, f"'{name}'").value,)
    if grid_literals.is_grid(node):
        if not grid_literals.has_glyphs(element):
            return value_lists.listed(node, element, prod(map(size_of, indices)), name)
        indices = flat_indices(indices) if isinstance(node, ast.ArrayLiteral) else indices
    match node:
        case ast.Literal(_, str()) if len(indices) == 1:
            return grid_literals.row(node, element, indices[0], name)
        case ast.Literal(span, str()):
            *above, last = map(size_of, indices)
            rows = " by ".join(map(str, above))
            raise _wrong_shape(
                name, f"is a grid of {rows} rows", span, f"a list of strings, each of {last} glyphs"
            )
        case ast.ArrayLiteral(span, items):
            expected = size_of(indices[0])
            if len(items) != expected:
                given = f"{len(items)} {'is' if len(items) == 1 else 'are'} given"
                raise _wrong_shape(
                    name,
                    f"takes {expected} entries, but {given}",
                    span,
                    f"one for each value of {indices[0]}",
                )
            parts = gather([partial(entries_of, i, scope, element, indices[1:], name) for i in items])
            return tuple(v for part in parts for v in part)
        case ast.Quantified(_, "distance"):
            return distances.table(node, scope, element, indices, name)
        case ast.Comprehension():
            return _comprehension(node, scope, element, indices, name)
        case ast.Name(span, other) if isinstance(scope.program.symbols.globals.get(other), ast.Const):
            source = scope.program.symbols.globals[other]
            assert isinstance(source, ast.Const)
            array = scope.program.const(source)
            if isinstance(array, ir.ConstantArray) and (array.type, array.indices) == (element, indices):
                return array.values
    wanted = " by ".join(str(size_of(i)) for i in indices)
    raise _wrong_shape(name, f"is an array of {wanted} entries", node.span, "write [a, b, ..] or [i in T: e]")


def _comprehension(
    node: ast.Comprehension, scope: Scope, element: Type, indices: tuple[Type, ...], name: str
) -> tuple[Value, ...]:
    binders = bind_types(node.binders, scope)
    require_indices(node, binders, indices[: len(binders)], name)
    count = prod(map(size_of, indices))
    if count > _MAX_ENTRIES:
        raise mistake(
            "E0605",
            f"'{name}' has {count} entries, more than the {_MAX_ENTRIES} that a comprehension may give",
            node.span,
            "use smaller index types",
        )
    if len(binders) == len(indices):
        bound = tuple(zip(node.binders, binders, strict=True))
        return tuple(constant_entries.values(node.body, bound, scope, element, f"'{name}'"))
    bind_all(node.binders, binders, scope)  # for its checks
    result: list[Value] = []
    for values in values_of(binders):
        inner = replace(scope, locals={**scope.locals, **values})
        result += entries_of(node.body, inner, element, indices[len(binders) :], name)
    return tuple(result)


def require_indices(
    node: ast.Comprehension, binders: tuple[ir.Binder, ...], indices: tuple[Type, ...], name: str
) -> None:
    """Raise unless the binders of ``node`` run over the index types of the array ``name``."""
    if tuple(b.type for b in binders) != indices:
        wanted = ", ".join(f"{b} in {t}" for b, t in zip("ijklmnpqrstuvw", indices, strict=False))
        raise _wrong_shape(
            name, f"is indexed by {', '.join(map(str, indices))}", node.span, f"write [{wanted}: ..]"
        )


def _wrong_shape(name: str, message: str, span: Span, remedy: str) -> Mistake:
    return mistake("E0309", f"'{name}' {message}", span, f"give {remedy}" if remedy[0] != "w" else remedy)
