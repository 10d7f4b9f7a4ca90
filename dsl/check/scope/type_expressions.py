# SPDX-License-Identifier: Apache-2.0
"""Type expressions to types, and the limits on types."""

from __future__ import annotations

from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.scope.grid_literals import check_glyphs
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.messages import e02_names, e03_types, e06_ranges, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import (
    BOOL,
    FLOAT,
    INT,
    INT32_MAX,
    PROB,
    Array,
    Enum,
    Float,
    Int,
    Record,
    Type,
    Variant,
    is_finite,
    size_of,
    units,
)

_MAX_ENTRIES = 1 << 24
_BASIC: dict[str, Type] = {"bool": BOOL, "int": INT, "float": FLOAT, "prob": PROB}


def resolve(node: ast.TypeExpr, program: Program) -> Type:
    """Return the type that ``node`` writes."""
    match node:
        case ast.TypeName(span, name, unit):
            if unit is not None:
                return Float(unit=units.parse(unit))
            return _BASIC[name] if name in _BASIC else _named(name, span, program)
        case ast.TypeRange(span, low_node, high_node):
            low, high = gather([partial(_bound, n, program) for n in (low_node, high_node)])
            if low > high:
                raise Mistake(e06_ranges.empty_range(low, high, span))
            return Int(low, high)
        case ast.TypeArray(span, element_node, index_nodes):
            element, *indices = gather([partial(resolve, n, program) for n in (element_node, *index_nodes)])
            if isinstance(element, Array):
                raise Mistake(e03_types.array_of_arrays(element_node.span))
            for index, index_node in zip(indices, index_nodes, strict=True):
                require_finite(index, index_node.span, "an array's index")
            found = Array(element, tuple(indices))
            require_length(found.indices, span)
            return found
    raise AssertionError(node)


def length(indices: tuple[Type, ...]) -> int:
    """Return the number of entries of an array with these index types."""
    result = 1
    for index in indices:
        result *= size_of(index)
    return result


def require_length(indices: tuple[Type, ...], span: Span) -> None:
    """Raise if an array with these index types has more entries than memory is for."""
    if length(indices) > _MAX_ENTRIES:
        raise Mistake(e06_ranges.many_entries(length(indices), _MAX_ENTRIES, span))


def scalar_type(node: ast.TypeExpr, program: Program) -> Type:
    """Return a type that is not an array."""
    found = program.type_of(node)
    if isinstance(found, Array):
        raise Mistake(e03_types.array_not_allowed(node.span))
    return found


def require_finite(t: Type, span: Span, what: str, instead: str = "") -> None:
    """Raise unless ``t`` has finitely many values; ``instead`` is what else could stand there."""
    if not is_finite(t):
        raise Mistake(e03_types.not_finite(what, t, instead, span))


def _bound(node: ast.Expr, program: Program) -> int:
    e = Scope(program, evaluate=True, constant=True).check(node)
    if not isinstance(e, ir.Const) or not isinstance(e.type, Int):
        raise Mistake(e08_parts.end_of_range_not_constant(node.span))
    return int(e.value)


def _named(name: str, span: Span, program: Program) -> Type:
    symbols = program.symbols
    item = symbols.types.get(name)
    if item is not None:
        if name in symbols.clashing:
            raise Mistake  # that the name was taken has been reported
        return program.named_type(item)
    if name in symbols.values or symbols.other_kind(name):
        raise Mistake(e02_names.not_a_type(name, span))
    raise Mistake(e02_names.unknown_type(name, [*symbols.types, *_BASIC], span))


def declared(item: ast.TypeAlias | ast.EnumDecl | ast.RecordDecl, program: Program) -> Type:
    """Return the type that a declaration makes."""
    match item:
        case ast.TypeAlias(_, _, node):
            found = resolve(node, program)
        case ast.EnumDecl(span, name, variants):
            if not variants:
                raise Mistake(e06_ranges.empty_enum(name, span))
            check_glyphs(variants)
            found = Enum(name, tuple(gather([partial(_variant, v, program) for v in variants])))
        case ast.RecordDecl(span, name, fields):
            seen: set[str] = set()
            for field in fields:
                if field.name in seen:
                    raise Mistake(e02_names.duplicate_field(name, field.name, field.span))
                seen.add(field.name)
            if not fields:
                raise Mistake(e06_ranges.empty_record(name, span))
            found = Record(name, tuple(gather([partial(_field, f, program) for f in fields])))
    if not isinstance(found, Array) and is_finite(found) and size_of(found) > INT32_MAX:
        raise Mistake(e06_ranges.many_values(item.name, size_of(found), item.span))
    return found


def _variant(node: ast.VariantDecl, program: Program) -> Variant:
    if node.argument is None:
        return Variant(node.name, None, node.glyph)
    argument = resolve(node.argument, program)
    require_finite(argument, node.argument.span, "a variant's argument")
    return Variant(node.name, argument)


def _field(node: ast.FieldDecl, program: Program) -> tuple[str, Type]:
    found = resolve(node.type, program)
    if not isinstance(found, Record | Float):
        require_finite(found, node.type.span, "a record's field", "a float, or a finite type")
    return node.name, found
