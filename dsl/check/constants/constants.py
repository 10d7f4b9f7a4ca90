# SPDX-License-Identifier: Apache-2.0
"""Consts and params: values that are known when the model is compiled, settings applied."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import prod

from hypgen.dsl import ir
from hypgen.dsl.check.constants import constant_entries, distances, value_lists
from hypgen.dsl.check.constants.text_error import error_of, exact_numbers
from hypgen.dsl.check.scope import grid_literals
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.terms.quantifiers import bind_all, bind_types, values_of
from hypgen.dsl.ir.evaluate import Value
from hypgen.dsl.messages import e03_values, e06_ranges
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Array, Type, flat_indices, size_of

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
    return array(item.name, element, indices, values, item.span, node)


def array(
    name: str, element: Type, indices: tuple[Type, ...], values: tuple[Value, ...], span: Span, node: ast.Expr
) -> ir.ConstantArray:
    """Return the array whose ``values`` are written as ``node``."""
    off, exact = error_of(node, element, values), exact_numbers(node, element, len(values))
    return ir.ConstantArray(name, element, indices, values, span, off, exact)


def param(item: ast.Param, program: Program) -> ir.Param:
    """Return a param with its default, if it has one."""
    element, indices = shape(program.type_of(item.type))
    node = program.overrides.get(item.name, item.default)
    default, error = None, 0.0
    if node is not None:
        scope = Scope(program, evaluate=True, constant=True)
        default = entries_of(node, scope, element, indices, item.name)
        error = error_of(node, element, default)
    return ir.Param(item.name, element, indices, default, item.span, error)


def entries_of(
    node: ast.Expr, scope: Scope, element: Type, indices: tuple[Type, ...], name: str
) -> tuple[Value, ...]:
    """Return the entries of an array written as ``node``, row-major."""
    if not indices:
        if isinstance(node, ast.ArrayLiteral | ast.Comprehension):
            raise Mistake(e03_values.array_for_value(name, element, node.span))
        return (constant_entries.scalar(node, scope, element, f"'{name}'").value,)
    if grid_literals.is_grid(node):
        if not grid_literals.has_glyphs(element):
            return value_lists.listed(node, element, prod(map(size_of, indices)), name)
        indices = flat_indices(indices) if isinstance(node, ast.ArrayLiteral) else indices
    match node:
        case ast.Literal(_, str()) if len(indices) == 1:
            return grid_literals.row(node, element, indices[0], name)
        case ast.Literal(span, str()):
            raise Mistake(e03_values.one_string_for_grid(name, indices, span))
        case ast.ArrayLiteral(span, items):
            if len(items) != size_of(indices[0]):
                raise Mistake(e03_values.wrong_length(name, indices[0], len(items), span))
            parts = gather([partial(entries_of, i, scope, element, indices[1:], name) for i in items])
            return tuple(v for part in parts for v in part)
        case ast.Quantified(_, "distance"):
            return distances.table(node, scope, element, indices, name)
        case ast.Comprehension():
            return _comprehension(node, scope, element, indices, name)
        case ast.Name(span, other) if isinstance(scope.program.symbols.values.get(other), ast.Const):
            source = scope.program.symbols.values[other]
            assert isinstance(source, ast.Const)
            array = scope.program.const(source)
            if isinstance(array, ir.ConstantArray) and (array.type, array.indices) == (element, indices):
                return array.values
    raise Mistake(e03_values.value_for_array(name, indices, node.span))


def _comprehension(
    node: ast.Comprehension, scope: Scope, element: Type, indices: tuple[Type, ...], name: str
) -> tuple[Value, ...]:
    binders = bind_types(node.binders, scope)
    require_indices(node, binders, indices[: len(binders)], name)
    count = prod(map(size_of, indices))
    if count > _MAX_ENTRIES:
        raise Mistake(e06_ranges.many_entries_of_comprehension(name, count, _MAX_ENTRIES, node.span))
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
        raise Mistake(e03_values.other_indexes(name, indices, node.span))
