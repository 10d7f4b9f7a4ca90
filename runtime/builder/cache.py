# SPDX-License-Identifier: Apache-2.0
"""The user's cache of builds: folders that are either whole or absent.

An entry is built in a folder of its own beside its place and renamed into it when it is whole, under a
file lock, so that processes that want the same entry wait for one of them to build it. Entries are
named by a hash of everything that went into them and are never changed.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from hypgen.cache_folder import cache_folder
from hypgen.runtime.builder.errors import ToolchainError

KEPT_ENTRIES = 64  # of one kind; those used last stay
LEFTOVER_SECONDS = 24 * 3600.0  # a temporary folder this old belongs to a process that was killed


def digest(*parts: str | bytes) -> str:
    """Return a name for the sequence ``parts``; where one part ends matters."""
    state = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()[:32]


def root() -> Path:
    """Return the folder of the cache, which need not exist."""
    try:
        return cache_folder()
    except RuntimeError:  # a `~` that stands for nothing
        raise ToolchainError(
            "this user has no home folder, so there is no place for the cache",
            "let the environment variable HYPGEN_CACHE_DIR name a folder that you may write to",
        ) from None


def folder(kind: str) -> Path:
    """Return the folder of all entries of a kind, made if need be."""
    path = root() / kind
    try:
        path.mkdir(parents=True, exist_ok=True)
        writable = os.access(path, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        raise ToolchainError(
            f"the cache folder '{path}' cannot be written",
            "let the environment variable HYPGEN_CACHE_DIR name a folder that you may write to",
        )
    return path


def entry(kind: str, key: str) -> Path | None:
    """Return the entry if it is there, and note its use."""
    path = root() / kind / key
    if not path.is_dir():
        return None
    with contextlib.suppress(OSError):  # a cache that others own may be read only
        os.utime(path)
    return path


def make(kind: str, key: str, build: Callable[[Path], None], *, again: bool = False) -> Path:
    """Return the entry, calling ``build`` with an empty folder to fill if there is none, or if ``again``."""
    parent = folder(kind)
    # One of sixteen locks: their number stays bounded, and a lock file never has to be removed.
    with _lock(parent / f"lock-{key[0]}"):
        found = entry(kind, key)
        if found is not None and not again:
            return found
        temporary = Path(tempfile.mkdtemp(prefix="tmp-", dir=parent))
        try:
            build(temporary)
            if found is not None:
                found.rename(temporary.with_suffix(".old"))
            temporary.rename(parent / key)
        finally:
            for rest in (temporary, temporary.with_suffix(".old")):
                shutil.rmtree(rest, ignore_errors=True)
    _prune(parent)
    return parent / key


def read_record(kind: str, name: str) -> dict[str, str]:
    """Return the record of this name, empty if there is none that can be read."""
    try:
        record = json.loads((root() / kind / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def write_record(kind: str, name: str, record: dict[str, str]) -> None:
    """Replace the record of this name; losing one costs an explanation, so failure is ignored."""
    with (
        contextlib.suppress(OSError, ToolchainError),
        tempfile.TemporaryDirectory(dir=folder(kind)) as temporary,
    ):
        path = Path(temporary) / "record"
        path.write_text(json.dumps(record, indent=1), encoding="utf-8")
        path.replace(root() / kind / f"{name}.json")


@contextlib.contextmanager
def _lock(path: Path) -> Iterator[None]:
    """Hold the lock file; the system frees it if the process dies."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _prune(parent: Path) -> None:
    """Remove the entries that were used longest ago, and what killed processes left behind."""
    now = time.time()
    entries: list[tuple[float, Path]] = []
    for path in parent.iterdir():
        with contextlib.suppress(OSError):
            used = path.stat().st_mtime
            if path.name.startswith("tmp-") and now - used > LEFTOVER_SECONDS:
                shutil.rmtree(path, ignore_errors=True)
            elif path.is_dir() and not path.name.startswith("tmp-"):
                entries.append((used, path))
    for _, path in sorted(entries, reverse=True)[KEPT_ENTRIES:]:
        shutil.rmtree(path, ignore_errors=True)
