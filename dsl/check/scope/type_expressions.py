"""Type expressions to types, and the limits on types."""

from __future__ import annotations

from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.scope.grid_literals import check_glyphs
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.messages.report import gather, mistake
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
                raise mistake(
                    "E0605",
                    f"the range {low} .. {high} has no values",
                    span,
                    "write the smaller end first; both ends belong to the range",
                )
            return Int(low, high)
        case ast.TypeArray(span, element_node, index_nodes):
            element, *indices = gather([partial(resolve, n, program) for n in (element_node, *index_nodes)])
            if isinstance(element, Array):
                raise mistake(
                    "E0304",
                    "an array of arrays",
                    element_node.span,
                    "list all indexes in one pair of brackets: T[A, B]",
                )
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
        raise mistake(
            "E0605",
            f"the array has {length(indices)} entries, more than {_MAX_ENTRIES}",
            span,
            "use smaller index types",
        )


def scalar_type(node: ast.TypeExpr, program: Program) -> Type:
    """Return a type that is not an array."""
    found = program.type_of(node)
    if isinstance(found, Array):
        raise mistake(
            "E0304",
            "an array cannot stand here",
            node.span,
            "use one value; index it by a formal or a binder",
        )
    return found


def require_finite(t: Type, span: Span, what: str, instead: str = "") -> None:
    """Raise unless ``t`` has finitely many values; ``instead`` is what else could stand there."""
    if not is_finite(t):
        raise mistake(
            "E0304",
            f"{what} must have a finite type, not {t}",
            span,
            f"use {instead}" if instead else "use bool, a range a .. b, an enum or a record",
        )


def _bound(node: ast.Expr, program: Program) -> int:
    e = Scope(program, evaluate=True, constant=True).check(node)
    if not isinstance(e, ir.Const) or not isinstance(e.type, Int):
        raise mistake(
            "E0810",
            "the end of a range must be a constant int",
            node.span,
            "use literals and consts of type int only",
        )
    return int(e.value)


def _named(name: str, span: Span, program: Program) -> Type:
    item = program.symbols.globals.get(name)
    if isinstance(item, ast.TypeAlias | ast.EnumDecl | ast.RecordDecl):
        return program.named_type(item)
    if item is not None:
        raise mistake("E0207", f"'{name}' is not a type", span, "name a type, an enum or a record here")
    types = [
        n
        for n, i in program.symbols.globals.items()
        if isinstance(i, ast.TypeAlias | ast.EnumDecl | ast.RecordDecl)
    ]
    raise mistake(
        "E0203",
        f"there is no type '{name}'",
        span,
        did_you_mean(name, [*types, *_BASIC]) or f"declare it: type {name} = 0 .. 9",
    )


def declared(item: ast.TypeAlias | ast.EnumDecl | ast.RecordDecl, program: Program) -> Type:
    """Return the type that a declaration makes."""
    match item:
        case ast.TypeAlias(_, _, node):
            found = resolve(node, program)
        case ast.EnumDecl(span, name, variants):
            if not variants:
                raise mistake("E0605", f"enum '{name}' has no variants", span, "name at least one")
            check_glyphs(variants)
            found = Enum(name, tuple(gather([partial(_variant, v, program) for v in variants])))
        case ast.RecordDecl(span, name, fields):
            seen: set[str] = set()
            for field in fields:
                if field.name in seen:
                    raise mistake(
                        "E0202",
                        f"record '{name}' has two fields '{field.name}'",
                        field.span,
                        "rename or remove one of the two",
                    )
                seen.add(field.name)
            if not fields:
                raise mistake("E0605", f"record '{name}' has no fields", span, "give it at least one")
            found = Record(name, tuple(gather([partial(_field, f, program) for f in fields])))
    if not isinstance(found, Array) and is_finite(found) and size_of(found) > INT32_MAX:
        raise mistake(
            "E0605",
            f"'{item.name}' has {size_of(found)} values, more than fit 31 bits",
            item.span,
            "use smaller types",
        )
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
