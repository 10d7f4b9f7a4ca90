# SPDX-License-Identifier: Apache-2.0
"""Checking expressions: syntax to typed IR, one function for each kind of node."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.expressions import calls
from hypgen.dsl.check.scope.draw_syntax import bind_value, is_draw, misplaced
from hypgen.dsl.check.scope.fit_type import assumed, check_as, require_int32, unify
from hypgen.dsl.check.scope.let_bindings import let_in
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_exponent, require_same
from hypgen.dsl.check.terms import matching, quantifiers, references
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.nodes import placed
from hypgen.dsl.messages import e02_names, e03_types, e03_values, e04_variables, e06_ranges, e07_draws
from hypgen.dsl.messages.report import Mistake, gather, unreachable
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import BOOL, INT, Enum, Float, Int, Record, Type, intervals

_COMPARISONS = {"==": "eq", "!=": "ne", "<": "lt", "<=": "le", ">": "gt", ">=": "ge"}
_ARITHMETIC = {"+": "add", "-": "sub", "*": "mul", "/": "div", "//": "floordiv", "%": "mod"}
_MAX_EXPONENT = 64


def check(node: ast.Expr, scope: Scope, expected: Type | None = None) -> ir.Expr:
    """Return ``node`` as a typed expression whose ints lie in int32."""
    if scope.evaluate:
        scope.budget.spend(node.span)
    found = _dispatch(node, scope, expected)
    found = require_int32(assumed(found, INT) if scope.open_ints else found, node.span)
    if isinstance(found, ir.Checked | ir.Quantified):
        found = placed(found, node.span)
    return scope.narrow(found)


def _dispatch(node: ast.Expr, scope: Scope, expected: Type | None) -> ir.Expr:
    match node:
        case ast.Literal(span, value, exact):
            if isinstance(value, str):
                raise Mistake(e03_values.string_in_expression(value, span))
            if math.isinf(intervals.float32(value)):
                raise Mistake(e06_ranges.beyond_float32(value, span))
            return operators.literal(value, exact)
        case ast.Name() | ast.Member() | ast.Index():
            return references.check(node, scope, expected)
        case ast.Unary():
            return _unary(node, scope)
        case ast.Binary(_, "and" | "or"):
            return _connective(node, scope)
        case ast.Binary(_, op) if op in _COMPARISONS:
            return _comparison(node, scope)
        case ast.Binary(_, "**"):
            return _power(node, scope)
        case ast.Binary():
            return _arithmetic(node, scope)
        case ast.Prime():
            return _prime(node, scope, expected)
        case ast.Is():
            return _is_variant(node, scope)
        case ast.With():
            return _changed(node, scope, expected)
        case ast.Call():
            return calls.check(node, scope, expected)
        case ast.Quantified():
            return quantifiers.check(node, scope, expected)
        case ast.If():
            return _conditional(node, scope, expected)
        case ast.LetIn():
            return _let_in(node, scope, expected)
        case ast.Match():
            return matching.check(node, scope, expected)
        case ast.ArrayLiteral(span) | ast.Comprehension(span):
            raise Mistake(e03_values.array_in_expression(span))
        case ast.TableLiteral(span):
            raise misplaced(e07_draws.TABLE, node, scope)
    raise AssertionError(node)


def _unary(node: ast.Unary, scope: Scope) -> ir.Expr:
    if node.op == "not":
        return operators.invert(check_as(node.operand, scope, BOOL, "the operand of 'not'"))
    if isinstance(node.operand, ast.Literal):  # so that -2147483648 is an int
        operand = _dispatch(node.operand, scope, None)
    else:
        operand = check(node.operand, scope)
    require_number(operand, node.operand.span, "the operand of '-'")
    return operators.negate(operand)


def require_number(e: ir.Expr, span: Span, what: str) -> None:
    """Raise unless ``e`` is an int or a float."""
    if not operators.is_numeric(e.type):
        raise Mistake(e03_types.not_a_number(what, e.type, span))


def _connective(node: ast.Binary, scope: Scope) -> ir.Expr:
    what = f"an operand of '{node.op}'"
    left = check_as(node.left, scope, BOOL, what)
    known = scope.given(left, node.op == "and")
    _refuse_alternative(node, scope)
    if (scope.evaluate or scope.unrolling) and isinstance(left, ir.Const) and left.value == (node.op == "or"):
        return left
    right = check_as(node.right, known, BOOL, what)
    return operators.both(left, right) if node.op == "and" else operators.either(left, right)


def _refuse_alternative(node: ast.Binary, scope: Scope) -> None:
    """Raise if this is ``x == a or b``, where ``x == b`` is meant."""
    compared = node.left
    while isinstance(compared, ast.Binary) and compared.op in ("and", "or"):
        compared = compared.right
    match compared, node.right:
        case ast.Binary(_, "==" | "!=" as op, left), ast.Literal(_, int() | float() as value):
            written = str(value)
        case ast.Binary(_, "==" | "!=" as op, left), ast.Name(_, written):
            value = references.is_bare_variant(node.right, scope)
        case _:
            return
    if isinstance(value, bool) and not (value and isinstance(node.right, ast.Name)):
        return
    again = f"{left.name if isinstance(left, ast.Name) else '..'} {op} {written}"
    raise Mistake(e03_types.value_as_condition(node.op, written, again, node.right.span))


def _pair(node: ast.Binary, scope: Scope) -> tuple[ir.Expr, ir.Expr]:
    """Check two operands; a bare variant on one side takes the enum of the other."""
    if references.is_bare_variant(node.left, scope) and not references.is_bare_variant(node.right, scope):
        right = check(node.right, scope)
        return check(node.left, scope, right.type), right
    if references.is_bare_variant(node.right, scope):
        left = check(node.left, scope)
        return left, check(node.right, scope, left.type)
    left, right = gather([partial(check, n, scope) for n in (node.left, node.right)])
    return left, right


def _comparison(node: ast.Binary, scope: Scope) -> ir.Expr:
    left, right = _pair(node, scope)
    op = _COMPARISONS[node.op]
    if operators.is_numeric(left.type) and operators.is_numeric(right.type):
        require_same([(left, node.left.span), (right, node.right.span)], "compare")
        compared = operators.compare(op, *operators.promote(left, right))
        floats = isinstance(left.type, Float) or isinstance(right.type, Float)
        if floats and op in ("eq", "ne") and scope.owner is not None and not isinstance(compared, ir.Const):
            scope.program.float_equalities.setdefault(scope.owner, {})[node.span] = None
        return compared
    if left.type != right.type:
        raise Mistake(e03_types.compares_types(node.op, left.type, right.type, node.span))
    if op not in ("eq", "ne"):
        raise Mistake(e03_types.without_order(left.type, node.span))
    return operators.compare(op, left, right)


def _arithmetic(node: ast.Binary, scope: Scope) -> ir.Expr:
    if node.op in ("//", "%"):  # what stands behind may be prose, and then nothing else is to be told
        right, left = _right_operand(node, scope), check(node.left, scope)
    else:
        left, right = gather([partial(check, node.left, scope), partial(_right_operand, node, scope)])
    for e, n in ((left, node.left), (right, node.right)):
        require_number(e, n.span, f"an operand of '{node.op}'")
    op = _ARITHMETIC[node.op]
    if op in ("add", "sub"):
        require_same([(left, node.left.span), (right, node.right.span)], "add" if op == "add" else "subtract")
    if op in ("floordiv", "mod"):
        for e, n in ((left, node.left), (right, node.right)):
            if isinstance(e.type, Float):
                raise Mistake(e03_types.integer_division_of_float(node.op, n.span))
    if op in ("div", "floordiv", "mod") and operators.ends(right.type) == (0, 0):
        raise Mistake(e06_ranges.division_by_zero(node.right.span))
    found = operators.arithmetic(op, left, right)
    if isinstance(found.type, Float):
        calls.refuse_undefined(found, node.op, node.span)
    return placed(found, node.span) if op in ("floordiv", "mod") else found


def _right_operand(node: ast.Binary, scope: Scope) -> ir.Expr:
    try:
        return check(node.right, scope)
    except Mistake as error:
        behind, sign = node.right, node.op
        if sign == "-" and isinstance(behind, ast.Unary):
            behind, sign = behind.operand, "--"
        if sign not in ("//", "%", "--") or not isinstance(behind, ast.Name | ast.Call):
            raise
        found = [e02_names.behind_comment_sign(d, sign, behind.span) for d in error.diagnostics]
        raise Mistake(*found) from None


def _power(node: ast.Binary, scope: Scope) -> ir.Expr:
    base, exponent = gather([partial(check, n, scope) for n in (node.left, node.right)])
    require_number(base, node.left.span, "the base of '**'")
    require_number(exponent, node.right.span, "the exponent of '**'")
    if not (
        isinstance(base.type, Int)
        and isinstance(exponent, ir.Const)
        and isinstance(exponent.type, Int)
        and exponent.value >= 0
    ):
        require_exponent(base, exponent, node.right.span)
        return calls.refuse_undefined(operators.power(base, exponent), "**", node.span)
    if exponent.value > _MAX_EXPONENT:
        raise Mistake(e06_ranges.large_exponent(exponent.value, node.right.span))
    return require_int32(_int_power(base, int(exponent.value), scope), node.span)


def _int_power(base: ir.Expr, exponent: int, scope: Scope) -> ir.Expr:
    assert isinstance(base.type, Int)
    low, high = intervals.int_power((base.type.low, base.type.high), exponent)
    if low == high:
        return operators.integer(low)
    name = scope.fresh("base")
    factor = base if references.is_atomic(base) else ir.Local(base.type, name)
    product = factor
    for _ in range(exponent - 1):
        product = operators.arithmetic("mul", product, factor)
    product = replace(product, type=Int(low, high)) if exponent > 1 else product
    return let_in(name, base, product)


def _prime(node: ast.Prime, scope: Scope, expected: Type | None) -> ir.Expr:
    if is_draw(node.operand, scope):
        raise Mistake(e07_draws.primed_draw(node.span))
    inner = enter_prime(node, scope)
    e = check(node.operand, inner, expected)
    require_state(node, scope)
    return e


def enter_prime(node: ast.Prime, scope: Scope) -> Scope:
    """Return the scope of what is primed."""
    if scope.primed:
        raise Mistake(e04_variables.primed_twice(node.span))
    return scope.prime()


def require_state(node: ast.Prime, scope: Scope) -> None:
    """Raise unless something under the prime changes in a step."""
    if not references.mentions_state(node.operand, scope):
        raise Mistake(e04_variables.idle_prime(node.span))


def _conditional(node: ast.If, scope: Scope, expected: Type | None) -> ir.Expr:
    condition = check_as(node.condition, scope, BOOL, "the condition of 'if'")
    yes, no = scope.given(condition), scope.given(condition, False)
    if isinstance(condition, ir.Const):
        live, dead = (node.then, node.otherwise) if condition.value else (node.otherwise, node.then)
        if not scope.evaluate and not scope.unrolling:
            unreachable(partial(check, dead, scope, expected))
        return check(live, scope, expected)
    if expected is None and references.is_bare_variant(node.then, scope):
        otherwise = check(node.otherwise, no)
        then = check(node.then, yes, otherwise.type)
    else:
        then, otherwise = gather(
            [partial(check, node.then, yes, expected), partial(check, node.otherwise, no, expected)]
        )
    then, otherwise = unify([(then, node.then.span), (otherwise, node.otherwise.span)], expected)
    return operators.choose(condition, then, otherwise)


def _let_in(node: ast.LetIn, scope: Scope, expected: Type | None) -> ir.Expr:
    value, inner = bind_value(node, scope)
    body = check(node.body, inner, expected)
    return let_in(node.name, value, body)


def _is_variant(node: ast.Is, scope: Scope) -> ir.Expr:
    e = check(node.operand, scope)
    if not isinstance(e.type, Enum):
        raise Mistake(e03_types.is_of_other(e.type, node.operand.span))
    if e.type.variant(node.variant) is None:
        raise Mistake(e02_names.unknown_variant(e.type, node.variant, node.span))
    return operators.is_variant(e.type, node.variant, e)


def _changed(node: ast.With, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return a record with some of its fields changed."""
    e = check(node.operand, scope, expected)
    if not isinstance(e.type, Record):
        raise Mistake(e03_types.with_of_other(e.type, node.operand.span))
    record, given = e.type, dict[str, ast.NewField]()
    for part in node.fields:
        if record.field_type(part.name) is None:
            raise Mistake(
                e02_names.unknown_field(record, part.name, [n for n, _ in record.fields], part.span)
            )
        if part.name in given:
            raise Mistake(e02_names.duplicate(part.name, part.span, given[part.name].span))
        given[part.name] = part
    name = scope.fresh("changed")
    whole = e if references.is_atomic(e) else ir.Local(record, name)

    def value_of(field: str, t: Type) -> ir.Expr:
        if field not in given:
            return operators.field(record, field, whole)
        return check_as(given[field].value, scope, t, f"field '{field}'")

    values = gather([partial(value_of, field, t) for field, t in record.fields])
    return let_in(name, e, operators.make_record(record, tuple(values)))
