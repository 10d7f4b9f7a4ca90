# SPDX-License-Identifier: Apache-2.0
"""User mistakes as data: what is wrong, where, and what to do about it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from hypgen.dsl.messages.source import Source, Span

_MOST_CANDIDATES = 500
_MOST_LETTERS = 2  # that a misspelt name has more or less, unless it begins alike
_PREFIX = 3


@dataclass(frozen=True)
class Diagnostic:
    """One mistake in a model: a stable ``code`` (``E0101``), its span, a message and a remedy.

    A ``code`` with a W (``W01``) is a warning: something that is allowed and yet doubtful.
    ``notes`` are further places that belong to the mistake, each with its own text. A diagnostic
    without a span (an unreadable file) names the file in its message.
    """

    code: str
    message: str
    span: Span | None
    remedy: str
    notes: tuple[tuple[Span, str], ...] = field(default=())

    @property
    def severity(self) -> str:
        """Return ``error`` or ``warning``."""
        return "warning" if self.code.startswith("W") else "error"


class ModelError(Exception):
    """The model has mistakes; carries every diagnostic found, in source order.

    ``sources`` holds the texts that the spans point into, by name, as far as they could be read.
    """

    def __init__(
        self, diagnostics: Iterable[Diagnostic], sources: Mapping[str, Source] | None = None
    ) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        self.sources: dict[str, Source] = dict(sources or {})
        super().__init__("; ".join(f"{d.code}: {d.message}" for d in self.diagnostics))


def did_you_mean(name: str, candidates: Iterable[str]) -> str:
    """Return ``did you mean 'x'?`` for the nearest candidate, or an empty string."""
    known = sorted(set(candidates))
    if len(known) > _MOST_CANDIDATES:  # comparing takes some 10 us each
        known = [c for c in known if c[:1] == name[:1] and abs(len(c) - len(name)) <= 2][:_MOST_CANDIDATES]
    near = [c for c in known if abs(len(c) - len(name)) <= _MOST_LETTERS]
    alike = [c for c in known if len(c) >= _PREFIX and c.startswith(name[:_PREFIX])]
    close = difflib.get_close_matches(name, near, n=1, cutoff=0.65)
    close = close or difflib.get_close_matches(name, alike, n=1, cutoff=0.6)
    return f"did you mean '{close[0]}'?" if close else ""
