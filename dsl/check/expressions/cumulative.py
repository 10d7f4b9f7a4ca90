# SPDX-License-Identifier: Apache-2.0
"""``cdf(law, x)``: how likely a law draws a number below x, as a formula of the law's parameters."""

from __future__ import annotations

from hypgen.dsl import ir
from hypgen.dsl.check.scope.let_bindings import let_in
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.unit_checks import require_same
from hypgen.dsl.check.terms.range_calls import number
from hypgen.dsl.check.terms.references import is_atomic
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e03_calls, e07_draws
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast

_ZERO, _ONE = operators.real(0.0), operators.real(1.0)


def cdf(node: ast.Call, scope: Scope) -> ir.Expr:
    """Return the probability below a number; of a law without a width it is 0 or 1."""
    if len(node.arguments) != 2:
        given = len(node.arguments)
        raise Mistake(e03_calls.wrong_arguments_of_builtin("cdf", given, "cdf(law, x)", node.span))
    drawn, at = node.arguments
    law = scope.draw(drawn, None, "the law")
    e = operators.to_float(number(at, scope, "cdf"))
    require_same([(ir.Local(law.type, ""), drawn.span), (e, at.span)], "go together in 'cdf'")
    name = scope.fresh("below")
    x = e if is_atomic(e) else ir.Local(e.type, name)
    return let_in(name, e, _below(law, x, drawn))


def _below(law: ir.Dist, x: ir.Expr, node: ast.Expr) -> ir.Expr:
    match law:
        case ir.Normal(mean=mean, deviation=deviation):
            distance = operators.arithmetic("sub", x, mean)
            return operators.normal_cdf(operators.arithmetic("div", distance, operators.absolute(deviation)))
        case ir.UniformFloat(low=low, high=high):
            part, whole = (operators.arithmetic("sub", end, low) for end in (x, high))
            inside = operators.clamp(operators.arithmetic("div", part, whole), 0.0, 1.0)
            jump = operators.choose(operators.compare("gt", x, high), _ONE, _ZERO)
            return operators.choose(operators.compare("gt", high, low), inside, jump)
        case ir.Exponential(mean=mean):
            power = operators.negate(operators.arithmetic("div", x, mean))
            below = operators.arithmetic("sub", _ONE, operators.rising("exp", power))
            return operators.choose(operators.compare("gt", x, _ZERO), below, _ZERO)
    raise Mistake(e07_draws.not_cumulative(node.span))
