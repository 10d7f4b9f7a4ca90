# SPDX-License-Identifier: Apache-2.0
"""A function's body under construction."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hypgen.codegen.tree.expr import Operand, of
from hypgen.codegen.tree.statements import Block, For, ForEach, If, Statement, While


class Code:
    """Collects statements, in the block that is open."""

    def __init__(self) -> None:
        self.body: Block = []
        self._open = self.body

    def add(self, statement: Statement) -> None:
        """Append a statement."""
        self._open.append(statement)

    @contextmanager
    def block(self, head: For | ForEach | While | If) -> Iterator[None]:
        """Append ``head`` and put what is added meanwhile into its block, the last one of an ``if``."""
        self.add(head)
        with self._within(head.branches[-1][1] if isinstance(head, If) else head.body):
            yield

    @contextmanager
    def when(self, test: Operand) -> Iterator[None]:
        """Put what is added meanwhile where ``test`` holds."""
        with self.block(If([(of(test), [])])):
            yield

    @contextmanager
    def or_when(self, test: Operand) -> Iterator[None]:
        """Put what is added meanwhile into an ``else if`` of the ``if`` that was added last."""
        block: Block = []
        self._last().branches.append((of(test), block))
        with self._within(block):
            yield

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """Put what is added meanwhile into the ``else`` of the ``if`` that was added last."""
        with self._within(self._last().otherwise):
            yield

    def join(self) -> None:
        """Let what was added last stand in one line, if it is one statement behind a head."""
        if self._open and isinstance(last := self._open[-1], If | For | ForEach):
            last.short = True

    def _last(self) -> If:
        last = self._open[-1]
        assert isinstance(last, If)
        return last

    @contextmanager
    def _within(self, block: Block) -> Iterator[None]:
        outer, self._open = self._open, block
        yield
        self._open = outer
