# SPDX-License-Identifier: Apache-2.0
"""What becomes of a printed value: it is returned, added, or stored."""

from __future__ import annotations

from dataclasses import dataclass

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import shape


@dataclass(frozen=True)
class Sink:
    """What to do with a value: ``return X;``, ``total += X;``, ``next.set_rover_x(X);``."""

    before: str
    after: str = ";"
    kept: object = None  # the shape of the value that is there already, for which there is nothing to do

    def keeps(self, expr: ir.Expr) -> bool:
        """Return whether ``expr`` is the value that is there already."""
        return self.kept is not None and shape(expr) == self.kept

    @property
    def returns(self) -> bool:
        """Return whether nothing behind the statement is reached."""
        return self.before == "return "

    def __call__(self, text: str) -> str:
        """Return the statement for a value."""
        return f"{self.before}{text}{self.after}"


RETURN = Sink("return ")
