# SPDX-License-Identifier: Apache-2.0
"""How a command ends, and what ``--help`` says about it."""

from __future__ import annotations

import enum


class Exit(enum.IntEnum):
    """How a command ends; ``run`` gives the solver's own code where the solver was started."""

    OK = 0
    DIFFERENT = 1  # `fmt --check` found something to do, `check --strict` a warning
    MISTAKE = 2  # the model, an option or the machine: the user can do something about it
    BUG = 70  # hypgen's own (sysexits' EX_SOFTWARE)
    INTERRUPTED = 130


EXIT_CODES = """\b
Exit codes:
  0    fine
  2    a mistake in the model or the options, or the machine lacks something
  70   a bug of hypgen; HYPGEN_DEBUG=1 shows where
  130  interrupted"""


def exit_codes(one: str) -> str:
    """Return the exit codes of a command that also ends with 1, and when it does."""
    return EXIT_CODES.replace("  2 ", f"  1    {one}\n  2 ", 1)
