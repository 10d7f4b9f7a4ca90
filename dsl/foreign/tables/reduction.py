# SPDX-License-Identifier: Apache-2.0
"""Leaves out of a table's reads those that change nothing, and sums over what cannot be read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from hypgen.dsl.foreign.tables.foreign_model import ForeignModel, Gain, Law, Read, combinations, position

Entry = TypeVar("Entry")


def reduced_law(law: Law, model: ForeignModel) -> Law:
    """Return ``law`` as a table of the reads that matter."""
    reads, rows = _reduced(law.reads, model.sizes(law.reads), law.rows)
    return Law(reads, rows)


def reduced_gain(gain: Gain, model: ForeignModel) -> Gain:
    """Return ``gain`` as a table of the reads that matter."""
    reads, values = _reduced(gain.reads, model.sizes(gain.reads), gain.values)
    return replace(gain, reads=reads, values=values)


def _reduced(
    reads: tuple[Read, ...], sizes: list[int], entries: Sequence[Entry]
) -> tuple[tuple[Read, ...], Sequence[Entry]]:
    kept: list[Read] = []
    stride = len(entries)
    for read, size in zip(reads, sizes, strict=True):
        stride //= size
        block = stride * size
        same = all(
            entries[at : at + stride] == entries[at + n * stride : at + (n + 1) * stride]
            for at in range(0, len(entries), block)
            for n in range(1, size)
        )
        if same:
            entries = [e for at in range(0, len(entries), block) for e in entries[at : at + stride]]
        else:
            kept.append(read)
    return tuple(kept), entries


def without_observations(gain: Gain, model: ForeignModel, notes: list[str]) -> Gain:
    """Return ``gain`` with what is observed replaced by its law: the agent does not see rewards."""
    seen = next((r for r in gain.reads if r.kind == "observation"), None)
    if seen is None:
        return gain
    note = "Rewards on observations are replaced by their expectation, which changes no value."
    if note not in notes:
        notes.append(note)
    law = model.sensors[seen.number]
    rest = tuple(r for r in gain.reads if r != seen)
    reads = rest + tuple(r for r in law.reads if r not in rest)
    sizes, law_sizes = model.sizes(gain.reads), model.sizes(law.reads)
    values = []
    for at in combinations(model.sizes(reads)):
        known = dict(zip(reads, at, strict=True))
        row = law.rows[position([known[r] for r in law.reads], law_sizes)]
        total = 0.0
        for value, probability in row:
            known[seen] = value
            total += probability * gain.values[position([known[r] for r in gain.reads], sizes)]
        values.append(total)
    return without_observations(Gain(gain.name, reads, values), model, notes)
