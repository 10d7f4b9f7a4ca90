# SPDX-License-Identifier: Apache-2.0
"""Reads what users name as a file, be it a device without an end or a pipe that nobody writes into."""

from __future__ import annotations

import os
import select
import stat

PIPE_SECONDS = 1.0  # how long a named pipe may have no writer at first


def read_file(path: str | os.PathLike[str], most: int) -> bytes:
    """Return the bytes of a file or a pipe, the first ``most + 1`` if it has more; raises ``OSError``.

    A named pipe that nobody writes into is empty.
    """
    with open(path, "rb", opener=_open) as stream:
        if stat.S_ISFIFO(os.fstat(stream.fileno()).st_mode):
            select.select([stream], [], [], PIPE_SECONDS)
        os.set_blocking(stream.fileno(), True)
        return stream.read(most + 1)


def _open(path: str, flags: int) -> int:
    # Without this flag, opening a named pipe would wait for a writer for ever.
    return os.open(path, flags | os.O_NONBLOCK)
