# SPDX-License-Identifier: Apache-2.0
"""Cores and GPUs that processes of a machine hold, so that no two cells share one.

Each is a lock on a file in the cache: the system frees it where its process dies.
"""

from __future__ import annotations

import fcntl
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from hypgen.experiments.process import POLL
from hypgen.runtime.builder import cache


class Stopped(Exception):
    """Nobody waits any more for what was to be played."""


def visible_gpus(count: int) -> list[str]:
    """Return the names of at most ``count`` GPUs that this process may use."""
    visible = os.environ.get("CUDA_VISIBLE_DEVICES", ",".join(map(str, range(count))))
    return [gpu for gpu in visible.split(",") if gpu][:count]


def visible_cores() -> list[int]:
    """Return the cores that this process may use."""
    return sorted(os.sched_getaffinity(0))


@contextmanager
def held(
    cores: int, gpus: Sequence[str], is_stopped: Callable[[], bool]
) -> Iterator[tuple[list[int], str | None]]:
    """Wait for so many cores, and for one of ``gpus`` if there are any, and hold them.

    Who waits is served before those that come later, so that many small cells do not keep out a large one.
    Raises ``Stopped``.
    """
    with ExitStack() as mine:
        with ExitStack() as turn:
            _gather(turn, "turn", [""], 1, is_stopped)
            taken = _gather(mine, "core", list(map(str, visible_cores())), cores, is_stopped)
            gpu = _gather(mine, "gpu", gpus, 1, is_stopped)[0] if gpus else None
        yield [int(core) for core in taken], gpu


def _gather(
    mine: ExitStack, kind: str, names: Sequence[str], count: int, is_stopped: Callable[[], bool]
) -> list[str]:
    """Lock ``count`` of some names, one by one as they get free."""
    folder = cache.folder("shares")
    found: list[str] = []
    while True:
        for name in names:
            path = folder / f"{platform.node()}-{kind}{name}"  # several machines may have one home
            if len(found) < count and name not in found and _lock(mine, path):
                found.append(name)
        if len(found) == min(count, len(names)):
            return found
        if is_stopped():
            raise Stopped
        time.sleep(POLL)


def _lock(mine: ExitStack, path: Path) -> bool:
    """Lock a file unless another holds it."""
    with ExitStack() as opened:
        file = opened.enter_context(path.open("w"))
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        mine.push(opened.pop_all())
        return True
