# SPDX-License-Identifier: Apache-2.0
"""Texts of E09xx that Cassandra's format and POMDPX share, and of files as a whole.

Texts about one of the two are in ``e09_cassandra`` and ``e09_pomdpx``.
"""

from __future__ import annotations

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span


def endless_sums(reason: str, path: str, limited: str, span: Span | None) -> Diagnostic:
    """A discount of 1 without a horizon where, for the ``reason``, values may be infinite.

    ``limited`` is a name for the model with a horizon.

    Both names are quoted as a shell needs them.
    """
    return Diagnostic(
        "E0908",
        f"the discount is 1, and {reason}: values are sums without end",
        span,
        f"`hypgen import {path} --horizon 100 -o {limited}` "
        f"ends episodes after 100 steps; then take {limited}",
    )


def no_discount(reason: str, path: str, limited: str, span: Span | None) -> Diagnostic:
    """A file that gives no discount, and no horizon; the names are those of ``endless_sums``."""
    told = endless_sums(reason, path, limited, span)
    message = f"no discount is given, which counts as 1, and {reason}: values are sums without end"
    return Diagnostic(told.code, message, span, f"add a line `discount: 0.95`; or {told.remedy}")


def wrong_sum(row: str, total: float, more: int, span: Span) -> Diagnostic:
    """A row that does not sum to 1, and ``more`` of the same specification with the same sum."""
    message = f"the probabilities of {row} sum to {total:.6g}"
    if more:
        message += f", and so do those of {more} more {'row' if more == 1 else 'rows'} written here"
    return Diagnostic("E0904", message, span, "make them sum to 1")


def rough_sums(row: str, total: float, more: int, command: str, span: Span) -> Diagnostic:
    """A row, and ``more`` of the file, whose numbers are rounded; ``command`` scales them."""
    message = f"the probabilities of {row} sum to {total:.6g}"
    if more:
        message += f", and {more} more {'row is' if more == 1 else 'rows are'} off 1 by at most 0.01"
    return Diagnostic("E0904", message, span, f"if the numbers are rounded, `{command}` scales them")


def more_wrong_sums(count: int, span: Span) -> Diagnostic:
    """Rows that do not sum to 1, besides those that are cited."""
    message = f"{count} more {'row does' if count == 1 else 'rows do'} not sum to 1"
    return Diagnostic("E0904", message, span, "make them sum to 1")


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
