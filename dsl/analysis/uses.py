"""Who reads what: every read of a declaration, with its place in the text.

Owners and what they read are nodes of one graph. Functions and lets are both; ``closure`` follows them and
gives, for each variable, draw and the action, the first path by which an owner comes to read it.
``ir.reads`` goes the same way through IR, which has neither paths nor, before all is checked, every body.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from hypgen.dsl.messages.source import Span


@dataclass(frozen=True)
class Use:
    """A read of ``name``: a ``variable``, ``let``, ``draw`` (a let that draws), ``fn`` or the ``action``.

    Of the history: ``memory``, ``last`` (an observation) and ``last action``.
    """

    kind: str
    name: str
    primed: bool
    span: Span

    @property
    def node(self) -> str:
        """Return the owner that stands for what is read."""
        return f"{'let' if self.kind == 'draw' else self.kind} {self.name}"


@dataclass(frozen=True)
class Reach:
    """What an owner comes to read, and the uses that lead there; the last is the read itself."""

    kind: str
    name: str
    primed: bool
    path: tuple[Use, ...]

    @property
    def span(self) -> Span:
        """Return where the owner's own text starts the path."""
        return self.path[0].span

    def route(self, start: str) -> str:
        """Return the path in words: ``policy default -> fn f -> rock.good``."""
        steps = [u.node for u in self.path[:-1]]
        return " -> ".join([start, *steps, self.name + ("'" if self.primed else "")])


class Uses:
    """The graph of reads."""

    def __init__(self) -> None:
        self._of: dict[str, dict[Use, None]] = {}

    def add(self, owner: str, use: Use) -> None:
        """Note that ``owner`` reads what ``use`` says."""
        self._of.setdefault(owner, {})[use] = None

    def of(self, owner: str) -> tuple[Use, ...]:
        """Return what ``owner`` itself reads."""
        return tuple(self._of.get(owner, ()))

    def owners(self) -> tuple[str, ...]:
        """Return all declarations that read something."""
        return tuple(self._of)

    def nodes(self, owner: str) -> set[str]:
        """Return ``owner`` and the functions and lets that it comes to read."""
        found, pending = {owner}, [owner]
        while pending:
            for use in self._of.get(pending.pop(), ()):
                if use.kind in ("fn", "let", "draw") and use.node not in found:
                    found.add(use.node)
                    pending.append(use.node)
        return found

    def closure(self, owner: str) -> list[Reach]:
        """Return all that ``owner`` reads, directly or through functions and lets, in order of first reach.

        Reading a function or let primed primes all that it reads.
        """
        found: dict[tuple[str, str, bool], Reach] = {}
        seen: set[tuple[str, bool]] = set()
        for reach in self._walk(owner, False, (), seen):
            found.setdefault((reach.kind, reach.name, reach.primed), reach)
        return list(found.values())

    def _walk(
        self, node: str, primed: bool, path: tuple[Use, ...], seen: set[tuple[str, bool]]
    ) -> Iterator[Reach]:
        for use in self._of.get(node, ()):
            use = replace(use, primed=use.primed or primed)
            here = (*path, use)
            if use.kind != "fn":
                yield Reach(use.kind, use.name, use.primed, here)
            if use.kind in ("fn", "let", "draw") and (use.node, use.primed) not in seen:
                seen.add((use.node, use.primed))
                yield from self._walk(use.node, use.primed, here, seen)
