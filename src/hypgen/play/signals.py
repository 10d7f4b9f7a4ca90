# SPDX-License-Identifier: Apache-2.0
"""Signals that end a run, and how they reach the program that runs."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # at run time only where a program runs
    import subprocess

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextlib.contextmanager
def passed_to(process: subprocess.Popen[str]) -> Iterator[list[int]]:
    """Send the signals that end a run on to a program; the list has those that came.

    The program ends as it likes. What this process ignores, and so the program too, stays ignored.
    """
    received: list[int] = []

    def pass_on(number: int, _: object) -> None:
        received.append(number)
        process.send_signal(number)

    if threading.current_thread() is not threading.main_thread():  # where no handler can be set
        yield received
        return
    heeded = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, pass_on) for number in heeded}
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
