# SPDX-License-Identifier: Apache-2.0
"""Values of whole states as tables: a bound that loops over a family becomes one load.

A formula that reads every member of a family of flags has as many values as the flags have patterns. They lie
side by side in a word of the state, so that the pattern is a mask away: it is one index of the table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeAlias

from hypgen.codegen.layout import limits
from hypgen.codegen.layout.nodes import ArrayBits, BeliefCall, HistoryRead
from hypgen.codegen.layout.state_layout import Field
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import walk
from hypgen.dsl.types import Int, is_finite, size_of

StateInput: TypeAlias = ir.StateRead | ArrayBits


def state_reads(value: ir.Expr, fields: Mapping[str, Field]) -> tuple[StateInput, ...] | None:
    """Return the variables that ``value`` depends on, arrays last; None where a table cannot hold it.

    ``value`` calls no functions, and ``fields`` has the variables that a step changes.
    """
    found: dict[str, StateInput] = {}
    for node in walk(value):
        match node:
            case ir.StateRead(variable=name, primed=False) if name in fields:
                found[name] = _whole(fields[name])
            case ir.StateRead() | ir.LetRead() | ir.ActionRead() | HistoryRead() | BeliefCall():
                return None
    reads = sorted(found.values(), key=lambda read: isinstance(read, ArrayBits))
    if not reads or not isinstance(reads[-1], ArrayBits):
        return None
    fits = all(_indexes(read, fields) for read in reads) and (
        math.prod(size_of(read.type) for read in reads) <= limits.MAX_STATE_TABLE_ENTRIES
    )
    return tuple(reads) if fits else None


def _whole(field: Field) -> StateInput:
    # The declared type, not a read's: a condition around the read may have narrowed that.
    if not field.indices:
        return ir.StateRead(field.type, field.variable)
    return ArrayBits(Int(0, (1 << field.length * field.width) - 1), field.variable)


def _indexes(read: StateInput, fields: Mapping[str, Field]) -> bool:
    """Return whether each value of ``read`` is the code of one value, or of one value for each entry."""
    if not isinstance(read, ArrayBits):
        return is_finite(read.type)
    field = fields[read.variable]
    return field.one_word and is_finite(field.type) and size_of(field.type) == 1 << field.width
