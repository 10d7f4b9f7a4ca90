# SPDX-License-Identifier: Apache-2.0
"""Calls: built-in functions, model functions, records and variants."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.analysis.uses import Use
from hypgen.dsl.check.expressions import belief_reads, cumulative, last_step
from hypgen.dsl.check.scope.draw_syntax import misplaced
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.symbols import kind_of
from hypgen.dsl.check.scope.unit_checks import require_plain, require_root, require_same
from hypgen.dsl.check.terms import guarded_reads, range_calls, recursion, references
from hypgen.dsl.check.terms.references import owner_of
from hypgen.dsl.ir import evaluate, operators, trigonometric_operators
from hypgen.dsl.ir.walk import children
from hypgen.dsl.messages import e02_names, e03_calls, e03_types, e06_ranges
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import lies
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk
from hypgen.dsl.types import INT, Enum, Int, Record, Type, builtin_names, size_of
from hypgen.dsl.types.units import PLAIN

_OF_ANY_UNIT = frozenset({"abs", "sign", "value"})
_FORMS = {"atan2": "y, x"}
_COUNTS = {"hypot": (2, 2), "atan2": (2, 2), "min": (2, None), "max": (2, None)}
_ONE_NUMBER: dict[str, Callable[[ir.Expr], ir.Expr]] = {
    "abs": operators.absolute,
    "sign": operators.sign,
    "value": lambda e: operators.measured(e, PLAIN),
    **{op: partial(operators.to_int, op) for op in builtin_names.ROUNDING},
    **{op: partial(operators.rising, op) for op in builtin_names.RISING},
    **{op: partial(trigonometric_operators.periodic, op) for op in trigonometric_operators.PERIODIC},
    **{op: partial(trigonometric_operators.arc, op) for op in trigonometric_operators.ARCS},
}


def check(node: ast.Call, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return the value of a call."""
    name = node.name
    if name in builtin_names.DRAWS:
        raise misplaced(f"{name}(..)", node, scope)
    symbols = scope.program.symbols
    if name in symbols.clashing and (name in symbols.functions or name in symbols.variants):
        raise Mistake  # that the name was taken has been reported
    if name == "last":
        return last_step.last(node, scope)
    if name in builtin_names.BELIEFS:
        return belief_reads.belief(node, scope)
    if name == "cdf":
        return cumulative.cdf(node, scope)
    if name in builtin_names.RANGES:
        return range_calls.check(node, scope, expected)
    if name == "at" and not (len(node.arguments) == 1 and name in symbols.variants):
        return guarded_reads.at(node, scope, expected)
    if name in builtin_names.FUNCTIONS and name != "at":
        return _builtin(node, scope)
    if name in builtin_names.QUANTIFIERS | builtin_names.TABLES:
        family = _family_inside(node, scope)
        raise Mistake(e03_calls.without_binder(name, _array_argument(node, scope), node.span, family))
    item = symbols.functions.get(name)
    if item is not None:
        if item.rhs.draw:
            raise misplaced(f"{name}(..)", node, scope)
        return _function(item, node, scope)
    record = symbols.record(name)
    if record is not None:
        return _record(record, node, scope)
    if name in symbols.variants:
        return _variant(node, scope, expected)
    value = symbols.values.get(name)
    kind = (
        "a local" if name in scope.locals else symbols.other_kind(name) if value is None else kind_of(value)
    )
    if kind is not None:
        raise Mistake(e02_names.not_a_function(name, kind, node.span))
    known = [
        *symbols.functions,
        *builtin_names.FUNCTIONS,
        *builtin_names.DRAWS,
        *scope.program.symbols.variants,
    ]
    own = builtin_names.FOREIGN_FUNCTIONS.get(name.lower())
    raise Mistake(e02_names.unknown_function(name, own, known, node.span))


def _array_argument(node: ast.Call, scope: Scope) -> tuple[str, tuple[Type, ...]] | None:
    """Return the name and indexes of the array that is a call's only argument."""
    if len(node.arguments) != 1:
        return None
    with suppress(Mistake):
        reference = references.find(node.arguments[0], scope)
        if reference is not None and reference.indices:
            return reference.label, reference.indices
    return None


def _family_inside(node: ast.Call, scope: Scope) -> str | None:
    """Return over what a family's members run that stands in a call without an index."""
    for found in walk(node):
        if isinstance(found, ast.Member) and isinstance(found.operand, ast.Name):
            element = scope.program.symbols.elements.get(found.operand.name)
            if element is not None and element.binder is not None:
                written = element.binder.type
                type_ = written.name if isinstance(written, ast.TypeName) else scope.program.type_of(written)
                return f"{element.binder.name} in {type_}"
    return None


def _arguments(node: ast.Call, count: int, signature: str) -> None:
    if len(node.arguments) != count:
        raise Mistake(e03_calls.wrong_arguments(node.name, count, len(node.arguments), signature, node.span))


def _function(item: ast.Function, node: ast.Call, scope: Scope) -> ir.Expr:
    program = scope.program
    formals = program.formals(item)
    _arguments(node, len(formals), f"{item.name}({', '.join(f'{f.name}: {f.type}' for f in formals)})")
    arguments = gather(
        [
            partial(check_as, n, scope, f.type, f"argument '{f.name}'")
            for n, f in zip(node.arguments, formals, strict=True)
        ]
    )
    if item.name in program.recursive:
        return recursion.call(item, arguments, node, scope)
    if scope.owner is not None:
        program.uses.add(scope.owner, Use("function", item.name, scope.primed, node.span))
    if scope.evaluate:
        return program.follow_call(item, arguments, scope)
    result = program.function(item).type
    if not scope.open_ints and any(f.type == INT for f in formals):
        result = _proven(item, arguments, node, scope)
    return ir.Call(result, item.name, tuple(arguments), scope.primed)


def _proven(item: ast.Function, arguments: list[ir.Expr], node: ast.Call, scope: Scope) -> Type:
    """Prove the ranges in the body of a function with formals of type ``int`` for these arguments."""
    inner = replace(scope, owner=None)
    try:
        return scope.program.follow_call(item, arguments, inner).type
    except Mistake as error:
        given = [
            f"'{f.name}' {lies(a.type.low, a.type.high)}"
            for f, a in zip(item.formals, arguments, strict=True)
            if isinstance(a.type, Int)
        ]
        note = (node.span, f"in this call of '{item.name}', where {', '.join(given)}")
        raise Mistake(*(replace(d, notes=(*d.notes, note)) for d in error.diagnostics)) from None


def _record(item: ast.RecordDecl, node: ast.Call, scope: Scope) -> ir.Expr:
    record = scope.program.named_type(item)
    assert isinstance(record, Record)
    _arguments(node, len(record.fields), f"{item.name}({', '.join(f'{n}: {t}' for n, t in record.fields)})")
    values = gather(
        [
            partial(check_as, n, scope, t, f"field '{name}'")
            for n, (name, t) in zip(node.arguments, record.fields, strict=True)
        ]
    )
    return operators.make_record(record, tuple(values))


def variant_with_argument(node: ast.Call, scope: Scope, expected: Type | None) -> tuple[Enum, Type]:
    """Return the enum whose variant a call makes, and the type of the argument."""
    enum = owner_of(node.name, node.span, scope, expected)
    variant = enum.variant(node.name)
    assert variant is not None
    if variant.argument is None:
        raise Mistake(e03_calls.variant_takes_none(node.name, node.span))
    _arguments(node, 1, f"{node.name}({variant.argument})")
    return enum, variant.argument


def _variant(node: ast.Call, scope: Scope, expected: Type | None) -> ir.Expr:
    enum, type_ = variant_with_argument(node, scope, expected)
    try:
        argument = check_as(node.arguments[0], scope, type_, f"the argument of '{node.name}'")
    except Mistake as error:
        span = node.arguments[0].span
        found = [e02_names.unknown_in_variant(d, node.name, span) for d in error.diagnostics]
        raise Mistake(*found) from None
    return operators.make_variant(enum, node.name, argument)


def _builtin(node: ast.Call, scope: Scope) -> ir.Expr:
    least, most = _COUNTS.get(node.name, (1, 1))
    given = len(node.arguments)
    if given < least or (most is not None and given > most):
        if node.name in builtin_names.QUANTIFIERS and (array := _array_argument(node, scope)) is not None:
            raise Mistake(e03_calls.without_binder(node.name, array, node.span))
        form = f"{node.name}({_FORMS.get(node.name, 'x' if least == 1 else 'a, b')})"
        raise Mistake(e03_calls.wrong_arguments_of_builtin(node.name, given, form, node.span))
    if node.name == "index":
        return _code(node, scope)
    values = gather([partial(range_calls.number, n, scope, node.name) for n in node.arguments])
    _check_units(node, values)
    match node.name:
        case "min" | "max":
            result = values[0]
            for value in values[1:]:
                result = operators.arithmetic(node.name, result, value)
            return result
        case "hypot":
            return operators.hypotenuse(values[0], values[1])
        case "atan2":
            return trigonometric_operators.arc_of_point(values[0], values[1])
    return refuse_undefined(_ONE_NUMBER[node.name](values[0]), node.name, node.span)


def refuse_undefined(e: ir.Expr, written: str, span: Span) -> ir.Expr:
    """Return ``e``; raise if it is a function of constants that has no finite value."""
    if isinstance(e, ir.Unary | ir.Binary):
        operands = [part.value for part in children(e) if isinstance(part, ir.Const)]
        is_known = len(operands) == (1 if isinstance(e, ir.Unary) else 2)
        if is_known and evaluate.value_of(e.op, e.type, *operands) is None:
            raise Mistake(e06_ranges.without_value(written, operands, span))
    return e


def _check_units(node: ast.Call, values: list[ir.Expr]) -> None:
    """Raise if a built-in function cannot take the units of its arguments."""
    name, spans = node.name, [n.span for n in node.arguments]
    if len(values) > 1:
        require_same(list(zip(values, spans, strict=True)), f"go together in '{name}'")
    elif name == "sqrt":
        require_root(values[0], spans[0])
    elif name not in _OF_ANY_UNIT:
        require_plain(values[0], spans[0], f"what '{name}' takes")


def _code(node: ast.Call, scope: Scope) -> ir.Expr:
    e = scope.check(node.arguments[0])
    if not isinstance(e.type, Enum | Record):
        raise Mistake(e03_types.index_of_other(e.type, node.arguments[0].span))
    if isinstance(e, ir.Const):
        return operators.integer(int(e.value))
    return operators.retyped(e, Int(0, size_of(e.type) - 1))
