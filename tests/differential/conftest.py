"""Lets these tests use the hand-built models of the unit tests."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent.parent / "unit"))
