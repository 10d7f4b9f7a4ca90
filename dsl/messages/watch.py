# SPDX-License-Identifier: Apache-2.0
"""How one looks on while the compiler works: what ``hypgen explain --stage`` is made with."""

from __future__ import annotations

from collections.abc import Callable

Watch = Callable[[str, object], None]
"""Is called after each pass of the compiler, with the pass's name and what it gave."""


def nobody(name: str, given: object) -> None:
    """Look on without doing anything."""
