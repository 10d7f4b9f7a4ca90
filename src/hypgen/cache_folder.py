# SPDX-License-Identifier: Apache-2.0
"""The folder of what hypgen makes once and keeps: libraries and solvers."""

from __future__ import annotations

import os
from pathlib import Path

from platformdirs import user_cache_path


def cache_folder() -> Path:
    """Return ``$HYPGEN_CACHE_DIR``, or else hypgen's part of the user's cache; it need not exist.

    Raises ``RuntimeError`` where a ``~`` stands for no folder.
    """
    own = os.environ.get("HYPGEN_CACHE_DIR")
    return Path(own or user_cache_path("hypgen", appauthor=False)).expanduser().absolute()
