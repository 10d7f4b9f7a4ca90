# SPDX-License-Identifier: Apache-2.0
"""Writes files so that neither a kill nor a crash of the machine leaves half of one."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from pathlib import Path


def write_whole(path: Path, content: str | bytes, *, replace: bool = True) -> None:
    """Write a file beside its place, sync it, and move it there.

    Links are followed, and rights stay. What is no regular file (a pipe, a device) is written to as it is.
    Without ``replace`` a file that is there raises ``FileExistsError``. Every ``OSError`` names ``path``.
    """
    data = content.encode() if isinstance(content, str) else content
    try:
        target = path.resolve() if replace else path
        mode = target.stat().st_mode if replace and target.exists() else None
        if mode is not None and not stat.S_ISREG(mode):
            target.write_bytes(data)
            return
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
        try:
            with open(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as stream:
                stream.write(data)
                stream.flush()
                if mode is not None:
                    os.fchmod(stream.fileno(), stat.S_IMODE(mode))
                os.fsync(stream.fileno())
            if replace:
                temporary.replace(target)
            else:
                os.link(temporary, target)  # fails where there is a file
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink()
        sync(target.parent)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None


def sync(path: Path) -> None:
    """Make a file, or the names in a folder, outlive a crash of the machine."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
