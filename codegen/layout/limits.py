# SPDX-License-Identifier: Apache-2.0
"""Figures that shape the generated code and none of its results."""

from __future__ import annotations

# A table derived at load has at most this many entries: 256 kB of floats, the size of a second-level cache.
MAX_TABLE_ENTRIES = 65536

# A table over the inputs of several parts replaces their own tables only while it stays this small,
# or this many times their size: first-level cache is dearer than an addition.
ALWAYS_JOIN_ENTRIES = 1024
JOIN_FACTOR = 8

# A value that takes this many simple operations is looked up in a table of at most so many codes, mostly a
# byte each: a few such tables fit in the first-level cache. A distribution's values may have a table for each
# of so many positions, as they lie side by side.
TABLE_COST = 8
MAX_CODE_TABLE_ENTRIES = 4096
MAX_POSITIONS = 8

# A table's formula has at most so many nodes when its calls are written out: functions that call functions
# grow without bound.
MAX_FORMULA = 10000

# A value of the whole state that takes this many simple operations is looked up even in a table that only a
# larger cache holds: 2 MB of floats, of which a search uses the few rows near its root.
STATE_TABLE_COST = 64
MAX_STATE_TABLE_ENTRIES = 1 << 19

# A group of reward terms has a table of at most this many entries (2 MB of floats) for its upper bound. To
# fill all tables takes so many steps of the small models at most, states times actions: under a second, or
# about two seconds of one core where the author declares no bound, as there is nothing else then.
MAX_GROUP_ENTRIES = 1 << 19
MAX_GROUPS_WORK = 1 << 24
MAX_UNDECLARED_WORK = 1 << 25
MAX_GROUP_TERMS = 256

# What the default policy earns is looked up in a table of at most this many entries: 256 kB of floats, as it
# lies beside the upper bound's, and a rollout of a larger model is worth its time.
MAX_EARNED_ENTRIES = 65536

# Agents that act apart share so many tokens of a group at most: to share n takes 2^n sums at each state.
MAX_SHARED_TOKENS = 12

# Where generated lines break.
LINE_LENGTH = 110
