# SPDX-License-Identifier: Apache-2.0
"""How far something long is: a bar where a person watches, else a line now and then."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from hypgen.cli.output import say

Show = Callable[[int, int, str], None]  # done, of how many, and what to say of it
ShowPhase = Callable[[str, int, int], None]  # what is done, how much of it, and of how much

_PATIENCE = 2.0  # seconds after which what takes longer says what it does


@contextmanager
def progress(things: str) -> Iterator[Show]:
    """Yield what shows how many things are done."""
    if not sys.stderr.isatty():
        shown = -1

        def tell(done: int, total: int, text: str) -> None:
            nonlocal shown
            if (tenth := 10 * done // max(1, total)) != shown:
                shown = tenth
                say(f"{done} of {total} {things}{': ' if text else ''}{text}")

        yield tell
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=Console(stderr=True)) as bar:
        row = bar.add_task("", total=None)

        def tell_bar(done: int, total: int, text: str) -> None:
            bar.update(row, total=total, completed=done, description=text)

        yield tell_bar


@contextmanager
def phases(clock: Callable[[], float] = time.process_time) -> Iterator[ShowPhase]:
    """Yield what shows how much of a phase is done; without a terminal, a line every two seconds.

    ``clock`` counts them: by default those of the processor, which a busy machine does not make more.
    """
    if not sys.stderr.isatty():
        said = clock()

        def tell(phase: str, done: int, total: int) -> None:
            nonlocal said
            if clock() - said > _PATIENCE:
                said = clock()
                say(f"{phase}: {done:,} of {total:,}")

        yield tell
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("")
        yield lambda phase, done, total: bar.update(task, description=phase, completed=done, total=total)


@contextmanager
def notice(text: str) -> Iterator[None]:
    """Say ``text`` if what is done meanwhile takes more than two seconds of processor time."""
    ended = threading.Event()
    threading.Thread(target=_say_later, args=(text, ended), daemon=True).start()
    try:
        yield
    finally:
        ended.set()


def _say_later(text: str, ended: threading.Event) -> None:
    begun, left = time.process_time(), _PATIENCE
    while not ended.wait(max(left, 0.1)):
        left = _PATIENCE - (time.process_time() - begun)
        if left <= 0:
            say(text)
            return
