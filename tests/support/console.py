# SPDX-License-Identifier: Apache-2.0
"""Runs a command line as the documentation shows it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def output(command: str, folder: Path) -> str:
    """Return what a command line prints in ``folder``, on either stream; ``hypgen`` is this checkout's."""
    script = f'hypgen() {{ {sys.executable} -c "from hypgen.cli.main import main; main()" "$@"; }}; {command}'
    done = subprocess.run(
        ["bash", "-c", script], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    return done.stdout
