# SPDX-License-Identifier: Apache-2.0
"""The body of a function under construction: its blocks, and what names stand for in them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial

from hypgen.codegen.cpp.text import loop
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.density_tables import DensityTable
from hypgen.codegen.passes.operand_order import OperandOrder
from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import Expr, Operand, of, op
from hypgen.codegen.tree.statements import For, ForEach, While
from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Type


@dataclass(frozen=True)
class Context:
    """What printing any expression of a model takes."""

    model: ir.Model
    names: Names
    needs: NeedsAnalysis
    order: OperandOrder
    index_types: dict[str, tuple[Type, ...]]  # of params, derived tables and constant arrays, by IR name
    beliefs: Mapping[int, ir.BeliefRead] = field(default_factory=dict)  # those that take a function
    masses: dict[Expr, str] = field(default_factory=dict)  # fields of Params, by the masses met so far
    density_tables: Mapping[ir.Dist, DensityTable] = field(default_factory=dict)


class BodyPrinter:
    """Keeps the code of one generated function, the C++ names that are taken, and locals of the model."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.names = context.names
        self.code = Code()
        self.scope = context.names.locals()
        self.locals: dict[str, Expr] = {}
        self.known: dict[object, Expr] = {}  # what is computed already, by its shape

    @contextmanager
    def when(self, test: Operand, chained: bool = False) -> Iterator[None]:
        """Put what is added meanwhile where ``test`` holds; ``chained``: in an ``else if``."""
        with self._names(), self.code.or_when(test) if chained else self.code.when(test):
            yield

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """Put what is added meanwhile into the ``else`` of the ``if`` before it."""
        with self._names(), self.code.otherwise():
            yield

    @contextmanager
    def block(self, head: For | ForEach | While) -> Iterator[None]:
        """Put what is added meanwhile into a loop."""
        with self._names(), self.code.block(head):
            yield

    @contextmanager
    def _names(self) -> Iterator[None]:
        """Free the names declared meanwhile again."""
        taken, known = set(self.scope.taken), dict(self.known)
        yield
        self.scope.taken, self.known = taken, known

    def bind(self, name: str, value: Operand) -> None:
        """Let a local of the model stand for ``value``."""
        self.locals[name] = of(value)

    def bind_new(self, name: str) -> str:
        """Let a local of the model stand for a new C++ local, whose name is given back."""
        local = self.scope.unique(name)
        self.bind(name, local)
        return local

    @contextmanager
    def loops(self, binders: Sequence[ir.Binder]) -> Iterator[None]:
        """Put what is added meanwhile into loops over the binders, the first outermost."""
        with ExitStack() as stack:
            for b in binders:
                stack.enter_context(self.loop(b, partial(loop, b.type)))
            yield
        self.code.join()

    @contextmanager
    def loop(self, binder: ir.Binder, head: Callable[[str], For]) -> Iterator[None]:
        """Put what is added meanwhile into a loop, whose ``head`` is made of its variable's name."""
        variable = self.scope.unique(binder.name)
        self.scope.taken.discard(variable)
        with self.block(head(variable)):
            self.bind_new(binder.name)
            if isinstance(binder.type, Bool):
                self.bind(binder.name, op(variable, "!=", 0))
            yield
