# SPDX-License-Identifier: Apache-2.0
"""Runs a command line as the documentation shows it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def output(command: str, folder: Path) -> str:
    """Return what a command line prints in ``folder``, on either stream; ``hypgen`` is this checkout's.

    What a slow machine says of its progress is left out: a page shows what every machine prints.
    """
    program = "from hypgen.cli import main, progress; progress._PATIENCE = 1e6; main.main()"
    script = f'hypgen() {{ {sys.executable} -c "{program}" "$@"; }}; {command}'
    done = subprocess.run(
        ["bash", "-c", script], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    return done.stdout
