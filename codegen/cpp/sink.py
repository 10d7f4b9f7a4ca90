# SPDX-License-Identifier: Apache-2.0
"""What becomes of a value: it is returned, added, or stored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from hypgen.codegen.tree.expr import Expr, Operand
from hypgen.codegen.tree.statements import Return, Statement, assign
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import shape


@dataclass(frozen=True)
class Sink:
    """What to do with a value: ``return X;``, ``total += X;``, ``next.set_rover_x(X);``."""

    statement: Callable[[Expr], Statement]
    returns: bool = False  # whether nothing behind the statement is reached
    kept: object = None  # the shape of the value that is there already, for which there is nothing to do

    def keeps(self, expr: ir.Expr) -> bool:
        """Return whether ``expr`` is the value that is there already."""
        return self.kept is not None and shape(expr) == self.kept

    def through(self, change: Callable[[Expr], Expr]) -> Sink:
        """Return the sink that takes what ``change`` makes of a value."""
        return replace(self, statement=lambda value: self.statement(change(value)), kept=None)

    def __call__(self, value: Expr) -> Statement:
        """Return the statement for a value."""
        return self.statement(value)


RETURN = Sink(Return, returns=True)


def into(target: Operand, sign: str = "=") -> Sink:
    """Return the sink that assigns to ``target``."""
    return Sink(lambda value: assign(target, value, sign))
