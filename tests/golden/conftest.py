"""``pytest tests/golden --accept`` writes what codegen gives today as the new golden files."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

# The hand-built models live beside the tests of single stages.
sys.path.insert(0, str(Path(__file__).parent.parent / "unit"))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--accept", action="store_true", help="take today's output as the golden files")
