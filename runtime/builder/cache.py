# SPDX-License-Identifier: Apache-2.0
"""The user's cache of builds: entries that are either whole or absent, and that only the user may change.

An entry is built in a folder of its own beside its place and renamed into it when it is whole, under a
file lock, so that processes that want the same entry wait for one of them to build it. Entries are
named by a hash of everything that went into them and are never changed. A manifest has the size and the
digest of each file: an entry that differs from it counts as absent.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hypgen.cache_folder import cache_folder
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.private_files import (
    ANOTHER_FOLDER,
    files,
    has_folder,
    make_folder,
    open_file,
    refuse_movable,
    seal,
)

KEPT_ENTRIES = 64  # of one kind; those used last stay
FILES, MANIFEST = "files", "manifest.json"  # in an entry's folder
HALF_MADE, LOCK = "tmp-", "lock-"  # how the names of others begin
KINDS = ("solvers", "runtime", "records", "logs")


@dataclass(frozen=True)
class Contents:
    """What the cache holds: how many entries, and the bytes of all files."""

    entries: int
    size: int


def digest(*parts: str | bytes) -> str:
    """Return a name for the sequence ``parts``; where one part ends matters."""
    state = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()[:32]


def root() -> Path:
    """Return the cache's folder, which need not exist; refuse it where others could replace it."""
    try:
        path = cache_folder()
    except RuntimeError:  # neither HOME nor an entry in the list of users
        raise ToolchainError("there is no home folder to keep the cache in", ANOTHER_FOLDER) from None
    refuse_movable(path)
    return path


def folder(kind: str) -> Path:
    """Return the folder of all entries of a kind, made if need be."""
    path = root() / kind
    try:
        for each in (path.parent, path):
            make_folder(each)
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
    """Return the folder with an entry's files if it is whole, and note its use."""
    parent = root() / kind
    try:
        if not has_folder(parent.parent):
            return None
        _remove_leftovers(parent.parent)
        if not has_folder(parent) or not has_folder(parent / key) or not _is_whole(parent / key):
            return None
    except OSError as error:
        raise _unusable(parent, error) from error
    with contextlib.suppress(OSError):  # on a disk that is read only
        os.utime(parent / key)
    return parent / key / FILES


def make(kind: str, key: str, build: Callable[[Path], None], *, again: bool = False) -> Path:
    """Return the entry, calling ``build`` with an empty folder to fill if there is none, or if ``again``."""
    parent = folder(kind)
    try:
        with _lock(parent, key):
            found = entry(kind, key)
            if found is not None and not again:
                return found
            temporary, old = parent / f"{HALF_MADE}{key}", parent / f"{HALF_MADE}{key}.old"
            for rest in (temporary, old):  # of a process that was killed
                _remove(rest)
            try:
                for each in (temporary, temporary / FILES):
                    each.mkdir(0o700)
                build(temporary / FILES)
                _write_manifest(temporary)
                with contextlib.suppress(FileNotFoundError):
                    (parent / key).rename(old)
                temporary.rename(parent / key)
            finally:
                for rest in (temporary, old):
                    _remove(rest)
        _prune(parent)
    except OSError as error:
        raise _unusable(parent, error) from error
    return parent / key / FILES


def read_record(kind: str, name: str) -> dict[str, str]:
    """Return the record of this name, empty if there is none that can be read."""
    try:
        record = json.loads(_read(root() / kind / f"{name}.json"))
    except (OSError, ValueError, ToolchainError):
        return {}
    return record if isinstance(record, dict) else {}


def write_record(kind: str, name: str, record: dict[str, str]) -> None:
    """Replace the record of this name; losing one costs an explanation, so failure is ignored."""
    with contextlib.suppress(OSError, ToolchainError):
        _write(folder(kind), f"{name}.json", json.dumps(record, indent=1))


def write_log(name: str, text: str) -> Path:
    """Keep a text for the user to read, and return its path."""
    parent = folder("logs")
    try:
        _write(parent, f"{name}.log", text)
        _prune(parent)
    except OSError as error:
        raise _unusable(parent, error) from error
    return parent / f"{name}.log"


def contents() -> Contents:
    """Return what the cache holds, and refuse what others may change in it."""
    entries = size = 0
    for parent in (folder(kind) for kind in KINDS):
        try:
            for path in (path for path in parent.iterdir() if not path.name.startswith(HALF_MADE)):
                found = list(files(path))
                entries += any(file.name == MANIFEST for file, _ in found)
                size += sum(n for _, n in found)
        except OSError as error:
            raise _unusable(parent, error) from error
    return Contents(entries, size)


def _is_whole(path: Path) -> bool:
    """Say whether an entry has the files of its manifest, and no others."""
    try:
        listed = json.loads(_read(path / MANIFEST))
        sizes = {file.relative_to(path / FILES).as_posix(): size for file, size in files(path / FILES)}
        if not isinstance(listed, dict) or {name: row[0] for name, row in listed.items()} != sizes:
            return False
        return all(_hash(path / FILES / name) == row[1] for name, row in listed.items())
    except (FileNotFoundError, NotADirectoryError, ValueError, TypeError, LookupError):
        return False


def _write_manifest(path: Path) -> None:
    """Take an entry's rights from others, and list its files."""
    seal(path)
    rows = {
        file.relative_to(path / FILES).as_posix(): [size, _hash(file)] for file, size in files(path / FILES)
    }
    with os.fdopen(open_file(path / MANIFEST, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "w") as file:
        json.dump(rows, file)


def _hash(path: Path) -> str:
    with os.fdopen(open_file(path, os.O_RDONLY), "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _read(path: Path) -> str:
    with os.fdopen(open_file(path, os.O_RDONLY), encoding="utf-8") as file:
        return file.read()


def _write(parent: Path, name: str, text: str) -> None:
    """Replace a file by one with this text."""
    with _lock(parent, name):
        temporary = parent / f"{HALF_MADE}{name}"
        _remove(temporary)
        try:
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
            with os.fdopen(open_file(temporary, flags), "w", encoding="utf-8") as file:
                file.write(text)
            temporary.replace(parent / name)
        finally:
            _remove(temporary)


@contextlib.contextmanager
def _lock(parent: Path, name: str, *, wait: bool = True) -> Iterator[bool]:
    """Hold the lock of all names with this first letter, and say so; the system frees it with the process.

    Locks are few, and a lock file never has to be removed.
    """
    file = open_file(parent / f"{LOCK}{name[:1]}", os.O_RDWR | os.O_CREAT)
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
            return
        yield True
    finally:
        os.close(file)


def _remove_leftovers(whole: Path) -> None:
    """Remove from the whole cache what is half made and has a free lock: its process was killed."""
    for parent in (whole / kind for kind in KINDS):
        for path in parent.glob(f"{HALF_MADE}*") if has_folder(parent) else ():
            name = path.name.removeprefix(HALF_MADE)
            with contextlib.suppress(OSError), _lock(parent, name, wait=False) as is_free:
                if is_free:
                    _remove(path)


def _prune(parent: Path) -> None:
    """Remove the entries that were used longest ago."""
    used: list[tuple[float, Path]] = []
    for path in _entries(parent):
        with contextlib.suppress(OSError):
            used.append((path.lstat().st_mtime, path))
    for _, path in sorted(used, reverse=True)[KEPT_ENTRIES:]:
        _remove(path)


def _entries(parent: Path) -> list[Path]:
    return [path for path in parent.iterdir() if not path.name.startswith((HALF_MADE, LOCK))]


def _remove(path: Path) -> None:
    """Remove a file, or a folder with all that is in it, as far as possible."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            path.unlink()


def _unusable(parent: Path, error: OSError) -> ToolchainError:
    is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    return ToolchainError(
        f"the cache cannot be used: '{error.filename or parent}': {error.strerror or error}",
        f"{'make room there' if is_full else 'look at its rights and its disk'}, or {ANOTHER_FOLDER}",
    )
