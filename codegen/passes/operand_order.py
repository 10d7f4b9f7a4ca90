# SPDX-License-Identifier: Apache-2.0
"""Which operand of ``and`` and ``or`` comes first: what is simple comes before what draws.

A draw costs dozens of operations, and compilers cannot leave it out: ``hit and pac.strong`` moves a ghost
before it looks whether the pill works. Operands change nothing, so their order shows in no result.
"""

from __future__ import annotations

from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.cost import Costs
from hypgen.codegen.passes.expr_shapes import needs_statements
from hypgen.codegen.passes.hoisting import Hoisting
from hypgen.dsl import ir

_SIMPLE = 8  # operations


class OperandOrder:
    """Knows the operands of one model."""

    def __init__(self, model: ir.Model, needs: NeedsAnalysis) -> None:
        self.needs = needs
        self.hoisting = Hoisting(model)
        self.costs = Costs({f.name: f for f in model.functions}, {x.name: x for x in model.all_lets})

    def ordered(self, expr: ir.Binary) -> ir.Binary:
        """Return ``and`` or ``or`` with the operand first that is evaluated first."""
        left, right = expr.left, expr.right
        if (
            "draws" in self.needs.of(left)
            and "draws" not in self.needs.of(right)
            and not needs_statements(right)
            and self.costs.of(right) <= _SIMPLE
            and self.hoisting.is_safe(right)
        ):
            return ir.Binary(expr.type, expr.op, right, left)
        return expr
