# SPDX-License-Identifier: Apache-2.0
"""Updates -> stages -> element updates: the units that run independently of each other.

An element update is what one element writes in one stage, for all its members. Updates of a stage write
different variables and read next-state values of earlier stages only, so their order is free and different
threads may take them. What a filter takes from the observation key is a unit of its own.

Warps that share a stage must not write one word of the packed state, as a write reads the rest of its word.
So members whose entries share a word stay together in a run, and a stage's runs are dealt to the warps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hypgen.codegen.layout.state_layout import Block
from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.guards import Guards, Index, own_value
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import shape
from hypgen.dsl.types import length_of, size_of

_FEWEST_RUNS = 4
_MOST_WARPS = 16  # of a block


@dataclass(frozen=True)
class ElementUpdate:
    """What an element (each member of a family) writes in a stage.

    ``observed``: the variables come with the observation key, so the filter does not draw them. ``guard``:
    where it is false nothing changes, for any member. ``indices``: the only entries that each assign changes.
    """

    element: ir.Element
    stage: int
    observed: bool
    assigns: tuple[ir.Assign, ...]
    guard: ir.Expr | None
    indices: tuple[Index, ...]

    @property
    def members(self) -> int:
        """Return how many members write: 1 for an element that is no family."""
        return 1 if self.element.binder is None else size_of(self.element.binder.type)


@dataclass(frozen=True)
class Share:
    """An element update as the warps of a block share it.

    Its members form ``runs`` of ``grain`` neighbours, the last perhaps shorter. Run i is number ``first + i``
    of the stage; of n warps, warp (first + i) % n takes it. An element's updates have equal shares, as they
    may write common words; no two elements' do.
    """

    update: ElementUpdate
    first: int
    grain: int

    @property
    def runs(self) -> int:
        """Return the number of runs."""
        return -(-self.update.members // self.grain)


def partition(model: ir.Model) -> tuple[tuple[ElementUpdate, ...], ...]:
    """Return the element updates, stage by stage. Variables that keep their value need none."""
    guards = Guards(model, NeedsAnalysis(model))
    visible = {v.name for v in model.variables if v.visible and not v.determined}
    stages = []
    for assigns in model.stages():
        groups: dict[tuple[str, bool], list[ir.Assign]] = {}
        for assign in assigns:
            if not _keeps(assign) or assign.variable in visible:
                owner = model.variable(assign.variable).element
                groups.setdefault((owner, assign.variable in visible), []).append(assign)
        stages.append(
            tuple(
                ElementUpdate(
                    element := next(e for e in model.elements if e.name == owner),
                    assigns[0].stage,
                    observed,
                    tuple(group),
                    None if observed else guards.update(tuple(group)),
                    tuple(guards.index(a, entry_binders(element, a)) for a in group),
                )
                for (owner, observed), group in groups.items()
            )
        )
    return tuple(stages)


def entry_binders(element: ir.Element, assign: ir.Assign) -> tuple[ir.Binder, ...]:
    """Return the binders of a variable's entries in one member of its element."""
    return assign.binders if element.binder is None else assign.binders[1:]


def _keeps(assign: ir.Assign) -> bool:
    return isinstance(assign.dist, ir.Certain) and shape(assign.dist.value) == shape(own_value(assign))


def shares(stage: Sequence[ElementUpdate], state: Block) -> tuple[Share, ...]:
    """Return how warps share a stage: runs are as short as the packing allows."""
    result: list[Share] = []
    first = 0
    for element in dict.fromkeys(update.element for update in stage):
        group = [update for update in stage if update.element == element]
        grain = _grain(group, state)
        result += (Share(update, first, grain) for update in group)
        first += result[-1].runs
    return tuple(result)


def run_count(stage: Sequence[Share]) -> int:
    """Return the number of runs of a stage: more warps find nothing to do."""
    return max((share.first + share.runs for share in stage), default=0)


def most_warps(stages: Sequence[Sequence[Share]]) -> int:
    """Return the most warps that are worth a block: a power of two.

    For two or three runs it is one: sharing gains little, and its kernels are half of what nvcc compiles.
    """
    most = max((run_count(stage) for stage in stages), default=1)
    return 1 << (min(most, _MOST_WARPS).bit_length() - 1) if most >= _FEWEST_RUNS else 1


def written_words(update: ElementUpdate, state: Block) -> list[frozenset[int]]:
    """Return for each member the words that hold what it writes."""
    fields = {field.variable: field for field in state.fields}
    words: list[set[int]] = [set() for _ in range(update.members)]
    for assign in update.assigns:
        entries = length_of(fields[assign.variable].indices) // update.members
        for member, written in enumerate(words):
            written.update(fields[assign.variable].words(member * entries, entries))
    return [frozenset(written) for written in words]


def _grain(group: Sequence[ElementUpdate], state: Block) -> int:
    """Return the smallest number of members such that runs of so many write no common word."""
    lowest: dict[int, int] = {}
    highest: dict[int, int] = {}
    for update in group:
        for member, words in enumerate(written_words(update, state)):
            for word in words:
                lowest[word] = min(lowest.get(word, member), member)
                highest[word] = max(highest.get(word, member), member)
    members = group[0].members
    spans = [(low, highest[word]) for word, low in lowest.items() if low < highest[word]]
    return next((g for g in range(1, members) if all(low // g == high // g for low, high in spans)), members)
