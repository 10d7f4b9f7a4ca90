# SPDX-License-Identifier: Apache-2.0
"""Tells, before anything is compiled, whether there is a place for it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from hypgen.runtime.builder import cache
from hypgen.runtime.builder.errors import ToolchainError

NEEDED_MEGABYTES = 64  # for the objects of the runtime, and for what a compiler writes on the way


def require_current_folder() -> None:
    """Refuse a current folder that is gone: compilers and CMake do not start there."""
    try:
        os.getcwd()
    except OSError:
        raise ToolchainError("the current folder is gone", "change to another with `cd`") from None


def require_room() -> None:
    """Refuse to compile where the cache or the folder for temporary files is full or cannot be written."""
    require_writable(cache.folder("solvers"), "HYPGEN_CACHE_DIR")
    require_writable(temporary_folder(), "TMPDIR")


def temporary_folder() -> Path:
    """Return the folder for temporary files, which compilers use too."""
    try:
        return Path(tempfile.gettempdir())
    except FileNotFoundError:
        raise ToolchainError(
            "there is no folder for temporary files that can be written",
            "let the environment variable TMPDIR name a folder with some room",
        ) from None


def free_megabytes(folder: Path) -> int:
    """Return how much room this user has in a folder."""
    facts = os.statvfs(folder)
    return facts.f_bavail * facts.f_frsize // 10**6


def require_writable(folder: Path, variable: str) -> None:
    """Refuse a folder without room for a build; ``variable`` of the environment can name another."""
    remedy = f"make room there, or let the environment variable {variable} name a folder with more"
    free = free_megabytes(folder)
    if free < NEEDED_MEGABYTES:
        raise ToolchainError(
            f"'{folder}' has {free} MB free, and compiling takes up to {NEEDED_MEGABYTES} MB", remedy
        )
    try:
        with tempfile.TemporaryFile(dir=folder) as file:  # a quota or a lack of inodes shows here alone
            file.write(b"\0" * 4096)
            file.flush()
    except OSError as error:
        raise ToolchainError(f"'{folder}' cannot be written: {error.strerror}", remedy) from None
