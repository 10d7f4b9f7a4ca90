# SPDX-License-Identifier: Apache-2.0
"""Files and folders that nobody but the user may change, so that what they hold can be trusted.

They are made with mode 0600 and 0700, whatever the umask. One that is a link, belongs to somebody else or
may be written by others is refused. Root may write everywhere, and is trusted like the machine.
"""

from __future__ import annotations

import contextlib
import os
import pwd
import stat
from collections.abc import Iterator
from pathlib import Path

from hypgen.runtime.builder.errors import ToolchainError

ANOTHER_FOLDER = "let the environment variable HYPGEN_CACHE_DIR name a folder of your own"
WRITABLE_FOR_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, where they are missing; refuse one that others may change."""
    if not path.parent.exists():
        make_folder(path.parent)
    try:
        path.mkdir(0o700)
    except FileExistsError:
        pass
    else:
        path.chmod(0o700)
    has_folder(path)


def has_folder(path: Path) -> bool:
    """Say whether a folder is there; refuse one that others may change."""
    try:
        status = path.lstat()
    except FileNotFoundError:
        return False
    refuse_others(path, status)
    return stat.S_ISDIR(status.st_mode)


def refuse_movable(path: Path) -> None:
    """Refuse a path that anybody could put something else at, as a folder above it has no sticky bit."""
    for folder in (Path(os.path.realpath(path.parent)) / "_").parents:
        with contextlib.suppress(OSError):
            mode = folder.stat().st_mode
            if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
                raise ToolchainError(
                    f"anybody may replace what is in '{folder}' ({stat.filemode(mode)}), above the cache",
                    f"run `chmod o-w {folder}`, or {ANOTHER_FOLDER}",
                )


def open_file(path: Path, flags: int) -> int:
    """Open a file and return its descriptor; refuse one that others may change."""
    try:
        # A pipe that stands there must not make the process wait.
        file = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o600)
    except OSError:
        with contextlib.suppress(FileNotFoundError):
            refuse_others(path, path.lstat())
        raise
    try:
        status = os.fstat(file)
        refuse_others(path, status)
        if not stat.S_ISREG(status.st_mode):
            raise _refusal(path, f"is no file ({stat.filemode(status.st_mode)})")
    except BaseException:
        os.close(file)
        raise
    return file


def files(path: Path) -> Iterator[tuple[Path, int]]:
    """Yield a file, or each one in a folder and its folders, with its size; refuse what others may change.

    What another process removes meanwhile is passed over.
    """
    with contextlib.suppress(FileNotFoundError):
        status = path.lstat()
        refuse_others(path, status)
        if stat.S_ISDIR(status.st_mode):
            for each in sorted(path.iterdir()):
                yield from files(each)
        else:
            yield path, status.st_size


def seal(folder: Path) -> None:
    """Take all rights to a folder and what is in it from others; a program stays one for its owner."""
    for path in (folder, *folder.rglob("*")):
        if not path.is_symlink():
            path.chmod(0o700 if path.is_dir() or os.access(path, os.X_OK) else 0o600)


def refuse_others(path: Path, status: os.stat_result) -> None:
    """Raise a ``ToolchainError`` for a link, and for what others own or may write."""
    if stat.S_ISLNK(status.st_mode):
        raise _refusal(path, "is a link, which hypgen does not follow")
    if status.st_uid != os.geteuid():
        user = owner(os.geteuid())
        raise _refusal(path, f"belongs to {owner(status.st_uid)}, and hypgen runs as {user}")
    if status.st_mode & WRITABLE_FOR_OTHERS:
        rights = stat.filemode(status.st_mode)
        raise ToolchainError(
            f"'{path}' of {owner(status.st_uid)} may be written by others ({rights}), so it is not used",
            f"run `chmod -R go-w {path}`, or {ANOTHER_FOLDER}",
        )


def owner(user: int) -> str:
    """Return a user's name, or the number of one without a name."""
    try:
        return pwd.getpwuid(user).pw_name
    except KeyError:
        return f"user {user}"


def _refusal(path: Path, reason: str) -> ToolchainError:
    return ToolchainError(f"'{path}' {reason}, so it is not used", f"remove it, or {ANOTHER_FOLDER}")
