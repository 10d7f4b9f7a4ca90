# SPDX-License-Identifier: Apache-2.0
"""The graph of reads: every read of a declaration, with its place in the text.

Owners and what they read are nodes of one graph. Functions and lets are both: ``closure`` follows them and
gives, for each variable, draw and the action, the first path by which an owner comes to read it.
``ir.reads`` goes the same way through IR, which has neither paths nor, before all is checked, every body.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from hypgen.dsl.analysis.owners import Owner, OwnerKind
from hypgen.dsl.messages.source import Span

ReadKind = Literal[
    "variable",
    "let",
    "draw",
    "policy let",
    "policy draw",
    "function",
    "action",
    "memory",
    "last",
    "last action",
]

# What is read through: kinds of reads whose own reads count as the reader's, with what they are owners of.
_THROUGH: dict[ReadKind, OwnerKind] = {
    "let": "let",
    "draw": "let",
    "policy let": "policy let",
    "policy draw": "policy let",
    "function": "function",
}


@dataclass(frozen=True)
class Use:
    """A read of ``name``: of a ``draw`` (a let that draws), of an observation of the past (``last``) ..."""

    kind: ReadKind
    name: str
    primed: bool
    span: Span

    @property
    def through(self) -> Owner | None:
        """Return the owner whose reads count as the reader's too; None where a read ends."""
        kind = _THROUGH.get(self.kind)
        return None if kind is None else Owner(kind, self.name)


@dataclass(frozen=True)
class Reach:
    """What an owner comes to read, and the uses that lead there; the last is the read itself."""

    kind: ReadKind
    name: str
    primed: bool
    path: tuple[Use, ...]

    @property
    def span(self) -> Span:
        """Return where the owner's own text starts the path."""
        return self.path[0].span

    def route(self, start: str) -> str:
        """Return the path in words: ``policy default -> fn f -> rock.good``."""
        steps = [str(u.through) for u in self.path[:-1]]
        return " -> ".join([start, *steps, self.name + ("'" if self.primed else "")])


class Uses:
    """The graph of reads."""

    def __init__(self) -> None:
        self._of: dict[Owner, dict[Use, None]] = {}

    def add(self, owner: Owner, use: Use) -> None:
        """Note that ``owner`` reads what ``use`` says."""
        self._of.setdefault(owner, {})[use] = None

    def of(self, owner: Owner) -> tuple[Use, ...]:
        """Return what ``owner`` itself reads."""
        return tuple(self._of.get(owner, ()))

    def owners(self) -> tuple[Owner, ...]:
        """Return all declarations that read something."""
        return tuple(self._of)

    def nodes(self, owner: Owner) -> set[Owner]:
        """Return ``owner`` and the functions and lets that it comes to read."""
        found, pending = {owner}, [owner]
        while pending:
            for use in self._of.get(pending.pop(), ()):
                through = use.through
                if through is not None and through not in found:
                    found.add(through)
                    pending.append(through)
        return found

    def closure(self, owner: Owner) -> list[Reach]:
        """Return all that ``owner`` reads, directly or through functions and lets, in order of first reach.

        Reading a function or let primed primes all that it reads.
        """
        found: dict[tuple[str, str, bool], Reach] = {}
        seen: set[tuple[Owner, bool]] = set()
        for reach in self._walk(owner, False, (), seen):
            found.setdefault((reach.kind, reach.name, reach.primed), reach)
        return list(found.values())

    def _walk(
        self, owner: Owner, primed: bool, path: tuple[Use, ...], seen: set[tuple[Owner, bool]]
    ) -> Iterator[Reach]:
        for use in self._of.get(owner, ()):
            use = replace(use, primed=use.primed or primed)
            here = (*path, use)
            if use.kind != "function":
                yield Reach(use.kind, use.name, use.primed, here)
            through = use.through
            if through is not None and (through, use.primed) not in seen:
                seen.add((through, use.primed))
                yield from self._walk(through, use.primed, here, seen)
