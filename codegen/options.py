"""Figures that shape the generated code and none of its results."""

from __future__ import annotations

# A table derived at load has at most this many entries: 256 kB of floats, the size of a second-level cache.
MAX_TABLE_ENTRIES = 65536

# A table over the inputs of several parts replaces their own tables only while it stays this small,
# or this many times their size: first-level cache is dearer than an addition.
ALWAYS_JOIN_ENTRIES = 1024
JOIN_FACTOR = 8

# Where generated lines break.
LINE_LENGTH = 110
