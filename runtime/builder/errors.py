# SPDX-License-Identifier: Apache-2.0
"""Errors between a generated project and a solver."""

from __future__ import annotations

from pathlib import Path


class ToolchainError(Exception):
    """The machine lacks something, or a folder cannot be used; ``remedy`` says what to do about it."""

    def __init__(self, message: str, remedy: str) -> None:
        self.message = message
        self.remedy = remedy
        super().__init__(f"{message}\n{remedy}")


class BuildError(Exception):
    """The compiler rejected hypgen's own C++: a bug of hypgen, never of the model. ``log`` has its output."""

    def __init__(self, what: str, log: Path) -> None:
        self.what = what
        self.log = log
        super().__init__(f"compiling {what} failed; see {log}")
