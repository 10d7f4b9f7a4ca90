"""``pytest tests/golden --accept`` writes what codegen gives today as the new golden files."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--accept", action="store_true", help="take today's output as the golden files")
