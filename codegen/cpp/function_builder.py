# SPDX-License-Identifier: Apache-2.0
"""Puts a generated function together: what it is given, where it comes from, and its body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.distributions import DistPrinter
from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.cpp.sink import RETURN, Sink
from hypgen.codegen.cpp.text import scalar
from hypgen.codegen.cpp.word import Word
from hypgen.codegen.layout.naming import base_name
from hypgen.codegen.passes.arguments import PARTS, Needs
from hypgen.codegen.passes.expr_shapes import needs_statements
from hypgen.codegen.tree.expr import Expr
from hypgen.codegen.tree.lines import head_of, statements
from hypgen.codegen.tree.statements import Function, Statement, names_in
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import shape
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Type

PART_TYPES = {
    "params": "const Params&",
    "fixed": "const Fixed&",
    "state": "const State&",
    "history": "const History&",
    "draws": "D&",
    "next": "const State&",
}


def origin(span: Span) -> str:
    """Return ``rock_sample.pomdp:12``."""
    return f"{base_name(span.file)}:{span.line}"


@dataclass
class Builder:
    """Collects one function's arguments and body."""

    context: Context
    printer: ExprPrinter = field(init=False)
    arguments: list[tuple[str, str]] = field(default_factory=list)
    preludes: list[tuple[str, Statement]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.printer = ExprPrinter(self.context)
        self.code = self.printer.code
        self.dist = DistPrinter(self.printer)

    def given(self, needs: Needs, **types: str) -> Builder:
        """Take the parts of ``needs`` as arguments, of the given C++ types where they differ from const."""
        for part in PARTS:
            if part in needs:
                name = self.context.names.action if part == "action" else part
                kind = types.get(part) or PART_TYPES.get(part) or action_type(self.context)
                self.arguments.append((kind, name))
        return self

    def local(self, name: str, type_: Type) -> Builder:
        """Take a formal or a family's member as an argument."""
        self.arguments.append((scalar(type_), self.printer.bind_new(name)))
        return self

    def take(self, kind: str, name: str) -> Builder:
        """Take an argument that no expression of the model sees."""
        self.arguments.append((kind, name))
        return self

    def prelude(self, name: str, line: Statement) -> Builder:
        """Start the body with a declaration of ``name``, if the body uses it."""
        self.preludes.append((name, line))
        return self

    def value(self, expr: ir.Expr) -> Builder:
        """Let the body give ``expr``."""
        self.printer.emit(expr, RETURN)
        return self

    def sampled(self, dist: ir.Dist, site: str, index: Expr, sink: Sink = RETURN) -> Builder:
        """Let the body draw from ``dist``."""
        self.dist.sample(dist, Word.of(site, index), sink)
        return self

    @contextmanager
    def guarded(self, guard: ir.Expr | None) -> Iterator[None]:
        """Put what is added meanwhile where ``guard`` holds, if there is one."""
        with self.printer.when(self._guard(guard)) if guard is not None else nullcontext():
            yield

    def _guard(self, guard: ir.Expr) -> Expr:
        """Return a condition; one that takes statements and stays the same is computed once."""
        if not needs_statements(guard) or self.context.needs.of(guard) & {"next", "draws"}:
            return self.printer.expr(guard)
        key = shape(guard)
        if key not in self.printer.known:
            holds = self.printer.expr(guard)
            self.printer.known[key] = holds
        return self.printer.known[key]

    def done(self, result: str, name: str, comment: Sequence[str] = ()) -> Function:
        """Return the function."""
        body = self.code.body
        for declared, statement in reversed(self.preludes):
            if declared in names_in(body):
                body = [statement, *body]
        kinds = {kind for kind, _ in self.arguments}
        template = ("class D",) if "D&" in kinds else ("class Real",) if "Real*" in kinds else ()
        return Function(
            result,
            name,
            self.arguments,
            body,
            tuple(comment),
            template=template,
        )


def laid_out(function: Function) -> template_data.Function:
    """Return a function as templates see it."""
    return template_data.Function(
        function.comment, tuple(head_of(function)), tuple(statements(function.body))
    )


def action_type(context: Context) -> str:
    """Return the C++ type in which functions take the action."""
    return "const Joint&" if context.model.action.indices else scalar(context.model.action.type)
