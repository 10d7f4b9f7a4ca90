# SPDX-License-Identifier: Apache-2.0
"""Node's packages, where a machine can fetch them."""

from __future__ import annotations

import functools
import shutil
import subprocess

import pytest


def require_npm() -> str:
    """Return npm's path; skip the test where there is none, or where it reaches no packages."""
    path = shutil.which("npm")
    if path is None:
        pytest.skip("needs npm")
    if not _reaches_packages(path):
        pytest.skip("npm reaches no packages")
    return path


@functools.cache
def _reaches_packages(path: str) -> bool:
    command = [path, "view", "pyodide", "version", "--fetch-retries=0", "--fetch-timeout=20000"]
    try:
        return subprocess.run(command, capture_output=True, timeout=60).returncode == 0
    except subprocess.TimeoutExpired:
        return False
