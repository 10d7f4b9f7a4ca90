# SPDX-License-Identifier: Apache-2.0
"""Arguments of generated functions: the parts of the argument list that a body reads."""

from __future__ import annotations

from collections.abc import Mapping

from hypgen.codegen.layout.nodes import ArrayBits, BeliefCall, HistoryRead
from hypgen.dsl import ir
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.walk import Node, children

# In the order of an argument list.
PARTS = ("params", "fixed", "state", "action", "history", "draws", "next")

Needs = frozenset[str]


class NeedsAnalysis:
    """The parts that expressions read, through functions and lets."""

    def __init__(self, model: ir.Model, beliefs: Mapping[int, ir.BeliefRead] | None = None) -> None:
        self.model = model
        self._beliefs = beliefs or {}
        self._fixed = {v.name for v in model.variables if v.fixed}
        self._functions = {f.name: f for f in model.functions}
        self._lets = {let.name: let for let in model.all_lets}
        self._known: dict[str, Needs] = {}

    def of(self, *nodes: Node) -> Needs:
        """Return the parts that the nodes read; a distribution that takes a word needs the draws."""
        found: set[str] = set()
        for node, primed in reached(nodes, self._functions, self._lets):
            found |= self._directly(node, primed)
        return frozenset(found)

    def of_density(self, dist: ir.Dist) -> Needs:
        """Return the parts that a density reads: draws only if it depends on a let that draws."""
        return self.of(*_expressions(dist))

    def function(self, name: str) -> Needs:
        """Return what the model function is given."""
        return self._body(f"fn {name}", self._functions[name].body)

    def belief(self, number: int) -> Needs:
        """Return what a belief's function is given: scratch states for hypotheses too."""
        read = self._beliefs[number]
        hidden = (v for v in self.model.variables if v.element == read.element and not v.visible)
        owners = {"fixed" if v.fixed else "state" for v in hidden}
        moments = next(f.moments for f in self.model.factors if f.element == read.element)
        parts = [read.operand, *([] if read.index is None else [read.index])]
        parts += [] if moments is None else moments.ends or ()
        return self.of(*parts) | owners | {"history"}

    def let(self, name: str) -> Needs:
        """Return what the let's function is given."""
        return self._body(f"let {name}", self._lets[name].dist)

    def _body(self, owner: str, body: Node) -> Needs:
        if owner not in self._known:
            self._known[owner] = self.of(body)
        return self._known[owner]

    def _directly(self, node: Node, next_state: bool) -> Needs:
        match node:
            case ir.ParamRead():
                return frozenset({"params"})
            case ir.StateRead(variable=name, primed=primed):
                part = "fixed" if name in self._fixed else "next" if primed or next_state else "state"
                return frozenset({part})
            case ArrayBits():
                return frozenset({"state"})
            case ir.ActionRead():
                return frozenset({"action"})
            case HistoryRead():
                return frozenset({"history"})
            case BeliefCall(number=number):
                return self.belief(number)
            case ir.Dist() if words_of(node):
                return frozenset({"draws"})
        return frozenset()


def _expressions(dist: ir.Dist) -> list[ir.Expr]:
    """Return the expressions of a distribution and of those inside it."""
    found: list[ir.Expr] = []
    for child in children(dist):
        found += [child] if isinstance(child, ir.Expr) else _expressions(child)
    return found
