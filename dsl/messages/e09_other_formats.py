# SPDX-License-Identifier: Apache-2.0
"""Texts of E09xx that Cassandra's format and POMDPX share, and of files as a whole.

Texts about one of the two are in ``e09_cassandra`` and ``e09_pomdpx``.
"""

from __future__ import annotations

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span


def endless_sums(path: str, limited: str, span: Span | None) -> Diagnostic:
    """A discount of 1 without a horizon; ``limited`` is a name for the model with one.

    Both names are quoted as a shell needs them.
    """
    return Diagnostic(
        "E0908",
        "the discount is 1, so that values are sums without end",
        span,
        f"`hypgen import {path} --horizon 100 -o {limited}` "
        f"ends episodes after 100 steps; then take {limited}",
    )


def large_file(path: str, most_bytes: int) -> Diagnostic:
    """A file of more than ``most_bytes``."""
    message = f"'{path}' is larger than {most_bytes // 1_000_000} MB, the most that can be imported"
    remedy = "give what is 0 not at all, and rows that are alike once, with `*`"
    return Diagnostic("E0912", message, None, remedy)


def large_model(length: int, most: int, span: Span | None) -> Diagnostic:
    """A file whose model in this language is a text of too many characters."""
    message = f"as a model of this language the file has {length / 1e6:.1f} MB, more than {most / 1e6:g}"
    return Diagnostic("E0912", message, span, "make the model smaller")


def unknown_format(path: str) -> Diagnostic:
    """A file in none of the formats that can be imported."""
    message = f"'{path}' is neither in Cassandra's format nor POMDPX"
    return Diagnostic("E0913", message, None, "a model of this language needs no import")
