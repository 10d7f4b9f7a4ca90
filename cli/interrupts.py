# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C, SIGTERM and SIGHUP: each ends a command as the others do."""

from __future__ import annotations

import signal
import time

from hypgen.play.signals import ENDING

SAME_SECONDS = 0.1


class Interrupted(KeyboardInterrupt):
    """A signal that ends the command."""

    def __init__(self, number: int) -> None:
        self.number = number


def catch_interrupts() -> None:
    """From now on the first signal raises ``Interrupted``, and a second one ends the process.

    One that comes within a tenth of a second counts as the first: `timeout` and shells send theirs twice.
    What was ignored at the start (`nohup`, a shell's background) stays so.
    """
    first: list[float] = []

    def on_signal(number: int, _: object) -> None:
        first.append(time.monotonic())
        if len(first) == 1:
            raise Interrupted(number)
        if first[-1] - first[0] > SAME_SECONDS:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, on_signal)


def interrupt_code(error: KeyboardInterrupt) -> int:
    """Return the exit code after an interrupt: 128 and the signal's number."""
    return 128 + (error.number if isinstance(error, Interrupted) else signal.SIGINT)
