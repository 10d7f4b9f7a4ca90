# SPDX-License-Identifier: Apache-2.0
"""Says in words what a machine lacks, where an exception tells: those are no bugs of hypgen."""

from __future__ import annotations

import errno
import os
import re

OUT_OF_MEMORY = "close other programs, or raise the limit that `ulimit -v` or the container sets"
FULL = "make room there; HYPGEN_CACHE_DIR and TMPDIR name other folders for what hypgen makes"
REMEDIES = {
    errno.ENOSPC: FULL,
    errno.EDQUOT: FULL,
    errno.EFBIG: "raise the limit that `ulimit -f` sets",
    errno.EACCES: "check who owns the file and its folder, and whether programs in it may be started",
    errno.EPERM: "check who owns the file and its folder",
    errno.EROFS: "name a folder that can be written; HYPGEN_CACHE_DIR and TMPDIR name hypgen's own",
    errno.EMFILE: "raise the limit that `ulimit -n` sets",
    errno.ENFILE: "close other programs: the system has no more open files",
    errno.EAGAIN: "close other programs, or raise the limit that `ulimit -u` or the container sets",
    errno.ENOMEM: OUT_OF_MEMORY,
    errno.EIO: "look for the disk's or the device's trouble in the system's log",
}
NO_THREAD = re.compile(r"can't start new thread|can't create new thread")
NO_MAPPING = re.compile(r"failed to map segment|[Cc]annot allocate memory|out of memory")


def explain(error: Exception) -> tuple[str, str] | None:
    """Return what is wrong with the machine and what to do, None if the error tells of something else."""
    if isinstance(error, MemoryError) or (isinstance(error, ImportError) and NO_MAPPING.search(str(error))):
        return "not enough memory", OUT_OF_MEMORY
    if isinstance(error, RuntimeError) and NO_THREAD.search(str(error)):
        return "the system gives no more threads", REMEDIES[errno.EAGAIN]
    if isinstance(error, ModuleNotFoundError) and not (error.name or "hypgen").startswith("hypgen"):
        return f"the Python package '{error.name}' is missing", "install hypgen again with pip"
    if isinstance(error, UnicodeEncodeError) and error.encoding.lower() in ("utf-8", "utf8"):
        return "a name of a file or in the environment is not UTF-8", "name it otherwise"
    if isinstance(error, UnicodeEncodeError):
        return (
            f"standard output takes {error.encoding} alone",
            "set PYTHONIOENCODING=utf-8 or a locale such as LC_ALL=C.UTF-8",
        )
    return explain_system_error(error) if isinstance(error, OSError) else None


def explain_system_error(error: OSError) -> tuple[str, str]:
    """Return what the system refuses and what to do."""
    reason = error.strerror or str(error) or type(error).__name__
    named = [
        os.fsdecode(n) for n in (error.filename, error.filename2) if isinstance(n, (str, bytes, os.PathLike))
    ]
    if not _has_current_folder():
        return "the current folder is gone", "change to another with `cd`"
    subject = f"'{named[0]}': " if named and named[0] else ""
    return subject + reason, REMEDIES.get(error.errno or 0, "check the file and the folder that it is in")


def _has_current_folder() -> bool:
    try:
        os.getcwd()
    except OSError:
        return False
    return True
