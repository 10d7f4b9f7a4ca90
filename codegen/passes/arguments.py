"""Arguments of generated functions: the parts of the argument list that a body reads."""

from __future__ import annotations

from collections.abc import Mapping, Set

from hypgen.codegen.layout.history_layout import BeliefCall, HistoryRead
from hypgen.codegen.layout.naming import takes_word
from hypgen.codegen.passes.state_tables import ArrayBits
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Node, walk

# In the order of an argument list.
PARTS = ("params", "fixed", "state", "action", "history", "draws", "next")

Needs = frozenset[str]


class NeedsAnalysis:
    """The parts that expressions read, through functions and lets."""

    def __init__(self, model: ir.Model, beliefs: Mapping[int, ir.BeliefRead] | None = None) -> None:
        self.model = model
        self._beliefs = beliefs or {}
        self._fixed = {v.name for v in model.variables if v.fixed}
        self._functions: dict[str, Needs] = {}
        self._lets: dict[str, Needs] = {}

    def of(self, *nodes: Node) -> Needs:
        """Return the parts that the nodes read; a distribution that takes a word needs the draws."""
        found: set[str] = set()
        for node in nodes:
            for inner in walk(node):
                found |= self._directly(inner)
        return frozenset(found)

    def function(self, name: str) -> Needs:
        """Return what the model function is given."""
        if name not in self._functions:
            body = next(f.body for f in self.model.functions if f.name == name)
            self._functions[name] = self.of(body)
        return self._functions[name]

    def belief(self, number: int) -> Needs:
        """Return what a belief's function is given: scratch states for hypotheses too."""
        read = self._beliefs[number]
        hidden = (v for v in self.model.variables if v.element == read.element and not v.visible)
        owners = {"fixed" if v.fixed else "state" for v in hidden}
        return self.of(read.operand, *([] if read.index is None else [read.index])) | owners | {"history"}

    def let(self, name: str) -> Needs:
        """Return what the let's function is given."""
        if name not in self._lets:
            self._lets[name] = self.of(next(e.dist for e in self.model.all_lets if e.name == name))
        return self._lets[name]

    def _directly(self, node: Node) -> Set[str]:
        match node:
            case ir.ParamRead():
                return {"params"}
            case ir.StateRead(variable=name, primed=primed):
                return {"fixed" if name in self._fixed else "next" if primed else "state"}
            case ArrayBits():
                return {"state"}
            case ir.ActionRead():
                return {"action"}
            case HistoryRead():
                return {"history"}
            case BeliefCall(number=number):
                return self.belief(number)
            case ir.Call(function=name, primed=primed):
                return _primed(self.function(name)) if primed else self.function(name)
            case ir.LetRead(let=name, primed=primed):
                return _primed(self.let(name)) if primed else self.let(name)
            case ir.Dist() if takes_word(node):
                return {"draws"}
        return frozenset()


def _primed(needs: Needs) -> Needs:
    return frozenset("next" if part == "state" else part for part in needs)
