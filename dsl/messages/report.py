# SPDX-License-Identifier: Apache-2.0
"""Raising, gathering and reporting diagnostics while a model is checked.

A check raises ``Mistake``. Independent parts run through ``gather``, so that one pass finds the mistakes of
all of them; ``Report.attempt`` is where a declaration's mistakes end. A ``Mistake`` without diagnostics says
that something used here is known to be wrong and has been reported at its own place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Span

T = TypeVar("T")
_MOST_DIAGNOSTICS = 100
_NOWHERE = Span("", 0, 0, 0, 0)


class Mistake(Exception):
    """One or more mistakes that keep a construct from having a meaning; none if already reported."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        self.diagnostics = diagnostics
        super().__init__("; ".join(d.message for d in self.diagnostics))


def gather(thunks: Sequence[Callable[[], T]]) -> list[T]:
    """Run all ``thunks`` and return their results; raise the mistakes of all that fail as one."""
    results: list[T] = []
    found: list[Diagnostic] = []
    failed = False
    for thunk in thunks:
        try:
            results.append(thunk())
        except Mistake as error:
            failed = True
            found += error.diagnostics
    if failed:
        raise Mistake(*found)
    return results


def unreachable(thunk: Callable[[], object]) -> None:
    """Check what a constant condition rules out: it may break ranges, and nothing else."""
    try:
        thunk()
    except Mistake as error:
        kept = [d for d in error.diagnostics if not d.code.startswith("E06")]
        if kept:
            raise Mistake(*kept) from None


class Report:
    """The diagnostics found so far, each once; the check ends where there are too many to read."""

    def __init__(self) -> None:
        self.found: dict[Diagnostic, None] = {}

    def add(self, error: Mistake) -> None:
        """Keep the diagnostics of ``error``."""
        self.found.update(dict.fromkeys(error.diagnostics))
        if len(self.found) >= _MOST_DIAGNOSTICS:
            self.raise_if_any()

    def attempt(self, thunk: Callable[[], T]) -> T | None:
        """Return what ``thunk`` gives, or keep its mistakes and return None."""
        try:
            return thunk()
        except Mistake as error:
            self.add(error)
            return None

    def raise_if_any(self) -> None:
        """Raise a ``ModelError`` with everything found, by position, if anything was."""
        if self.found:
            raise ModelError(sorted(self.found, key=lambda d: (d.span or _NOWHERE, d.code)))
