# SPDX-License-Identifier: Apache-2.0
"""How far something long is: a bar where a person watches, else a line now and then."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from hypgen.cli.output import say

Show = Callable[[int, int, str], None]  # done, of how many, and what to say of it


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
