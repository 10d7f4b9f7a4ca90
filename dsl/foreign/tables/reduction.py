# SPDX-License-Identifier: Apache-2.0
"""Leaves out of a table's reads those that change nothing, and sums over what cannot be read."""

from __future__ import annotations

from dataclasses import replace
from itertools import compress

from hypgen.dsl.foreign.tables.foreign_model import ForeignModel, Gain, Law, combinations
from hypgen.dsl.foreign.tables.table import Table


def reduced_law(law: Law) -> Law:
    """Return ``law`` as a table of the reads that matter."""
    kept = law.rows.tested()
    return Law(tuple(compress(law.reads, kept)), law.rows.without(kept))


def reduced_gain(gain: Gain) -> Gain:
    """Return ``gain`` as a table of the reads that matter."""
    kept = gain.values.tested()
    return replace(gain, reads=tuple(compress(gain.reads, kept)), values=gain.values.without(kept))


def without_observations(gain: Gain, model: ForeignModel, notes: list[str]) -> Gain:
    """Return ``gain`` with what is observed replaced by its law: the agent does not see rewards."""
    seen = next((r for r in gain.reads if r.kind == "observation"), None)
    if seen is None:
        return gain
    note = "Rewards on observations are replaced by their expectation, which changes no value."
    if note not in notes:
        notes.append(note)
    gain, law = reduced_gain(gain), reduced_law(model.sensors[seen.number])
    if seen not in gain.reads:
        return without_observations(gain, model, notes)
    rest = tuple(r for r in gain.reads if r != seen)
    reads = rest + tuple(r for r in law.reads if r not in rest)
    values = []
    for at in combinations(model.sizes(reads)):
        known = dict(zip(reads, at, strict=True))
        total = 0.0
        for value, probability in law.rows.at([known[r] for r in law.reads]):
            known[seen] = value
            total += probability * gain.values.at([known[r] for r in gain.reads])
        values.append(total)
    return without_observations(Gain(gain.name, reads, Table.of(model.sizes(reads), values)), model, notes)
