# SPDX-License-Identifier: Apache-2.0
"""How a command ends, and what ``--help`` says about it."""

from __future__ import annotations

import enum
import signal


class Exit(enum.IntEnum):
    """How a command ends; ``run`` gives the solver's own code where the solver was started.

    After an interrupt it is 128 and the signal's number.
    """

    OK = 0
    DIFFERENT = 1  # `fmt --check` found something to do, `check --strict` a warning
    MISTAKE = 2  # the model, an option, a file or the machine: the user can do something about it
    BUG = 70  # hypgen's own (sysexits' EX_SOFTWARE)
    INTERRUPTED = 130  # by Ctrl-C
    READER_IS_GONE = 141  # of standard output; as SIGPIPE ends other programs


EXIT_CODES = """\b
Exit codes:
  0    fine
  2    a mistake in the model or the options, output that cannot be written, or the machine lacks something
  70   a bug of hypgen; HYPGEN_DEBUG=1 shows where
  130  interrupted; 143 by SIGTERM, 129 by SIGHUP
  141  the reader of the output has gone"""

_ENDING = (signal.SIGHUP, signal.SIGINT, signal.SIGKILL, signal.SIGPIPE, signal.SIGTERM)  # not of a bug


def exit_codes(one: str) -> str:
    """Return the exit codes of a command that also ends with 1, and when it does."""
    return EXIT_CODES.replace("  2 ", f"  1    {one}\n  2 ", 1)


def code_of_program(code: int) -> int:
    """Return the exit code for that of a program: one that crashed has a bug, one that was ended has not."""
    if code >= 0:
        return code
    return 128 - code if -code in _ENDING else Exit.BUG
