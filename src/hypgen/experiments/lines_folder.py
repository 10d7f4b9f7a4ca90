# SPDX-License-Identifier: Apache-2.0
"""The folder in which solvers write the lines of cells that are not yet kept."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp

_PREFIX = "lines-"


@contextmanager
def lines_folder(parent: Path) -> Iterator[Path]:
    """Yield a new folder in ``parent``, which goes at the end with all that is in it.

    Those that killed processes left in ``parent`` go too. A lock tells whether a folder's process lives:
    the system frees it where the process dies.
    """
    with _locked(parent):
        for left in parent.glob(f"{_PREFIX}*"):
            _remove_if_free(left)
        folder = Path(mkdtemp(dir=parent, prefix=_PREFIX))
        mine = os.open(folder, os.O_RDONLY)
        fcntl.flock(mine, fcntl.LOCK_EX)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(mine)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    opened = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX)
        yield
    finally:
        os.close(opened)


def _remove_if_free(folder: Path) -> None:
    try:
        opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except OSError:
        return
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        shutil.rmtree(folder, ignore_errors=True)
    except BlockingIOError:
        pass
    finally:
        os.close(opened)
