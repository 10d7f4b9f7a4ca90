# SPDX-License-Identifier: Apache-2.0
"""Groups of reward terms, each worth at most what a small model of its own says.

The most that a sum of rewards can be is at most the sum of the most that its groups can be. A group needs the
variables that its terms, their updates, legality and the end read, and no others: who knows them all and may
do as is best for this group alone earns at least as much. Where a group's states and actions are few, the
value of that small model is computed when params are loaded, and looked up in ``bound upper``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

from hypgen.codegen.bounds.separate_agents import Team
from hypgen.codegen.layout import limits
from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.partition import ElementUpdate, partition
from hypgen.codegen.passes.read_sets import Entry, Reader, Reads, Term, alike, terms_of
from hypgen.dsl import ir
from hypgen.dsl.types import is_finite, length_of, low_of, size_of


@dataclass(frozen=True)
class Part:
    """A variable of a group: all of it (no members), or some members' entries."""

    variable: ir.Variable
    members: tuple[int, ...] = ()

    @property
    def entries(self) -> int:
        """Return how many values the part is."""
        length = length_of(self.variable.indices)
        if not self.members:
            return length
        return length // size_of(self.variable.indices[0]) * len(self.members)

    @property
    def bits(self) -> float:
        """Return the logarithm of the number of joint values."""
        return self.entries * math.log2(size_of(self.variable.type))


@dataclass(frozen=True)
class Group:
    """Terms that one table bounds, over the joint values of ``parts``, the first the most significant.

    ``actions`` are those that differ for the group; the others do as one of them does.
    """

    terms: tuple[Term, ...]
    parts: tuple[Part, ...]
    actions: tuple[int, ...]

    @property
    def states(self) -> int:
        """Return the number of the table's entries."""
        return math.prod(size_of(p.variable.type) ** p.entries for p in self.parts)


@dataclass(frozen=True)
class Relaxation:
    """The groups whose tables bound all rewards; none where ``reason`` says what forbids it.

    ``exact``: one group has all terms, so that the table is the value of knowing the state. ``declared``:
    the bound that the author wrote is a function of the group's variables, so that the table holds the less.
    ``earned``: so is what the default policy does, and a second table holds what it earns, as a lower bound.
    ``team``: its agents act apart. Each has a group for each share of the tokens, and groups that share
    tokens follow each other. ``together``: what forbids that, where the action is a product.
    """

    groups: tuple[Group, ...] = ()
    reason: str = ""
    declared: bool = False
    earned: bool = False
    team: Team | None = None
    together: str = ""

    @property
    def exact(self) -> bool:
        """Return whether no term is bounded apart from another."""
        return len(self.groups) == 1 and self.team is None


def grow(model: ir.Model) -> Relaxation:
    """Return the groups of the model's rewards, of all agents together."""
    return _Relaxer(model).result()


@dataclass(frozen=True)
class _Closure:
    """All that some terms depend on; no entries where these are too many or cannot be enumerated."""

    entries: frozenset[Entry]
    reason: str = ""


class _Relaxer:
    def __init__(self, model: ir.Model) -> None:
        self.model = model
        self.reader = Reader(model)
        self.needs = NeedsAnalysis(model)
        self.variables = {v.name: v for v in model.variables}
        self.updates = {a.variable: u for stage in partition(model) for u in stage for a in u.assigns}
        self.reads: dict[Entry, Reads] = {}
        self.every = Reads()  # what any group needs
        for condition in (model.legal, model.terminal):
            self.every.add(self.reader.of(condition, {}))

    def result(self) -> Relaxation:
        if self.model.discount == 1:
            return Relaxation(reason="the discount is 1")
        terms = [term for reward in self.model.rewards for term in terms_of(reward)]
        if not terms:
            return Relaxation(reason="there are no rewards")
        if len(terms) > limits.MAX_GROUP_TERMS:
            return Relaxation(reason=f"there are more than {limits.MAX_GROUP_TERMS} reward terms")
        found: list[Group] = []
        while terms:
            grown = self._grow(terms)
            if isinstance(grown, str):
                return Relaxation(reason=grown)
            found.append(grown)
            terms = [term for term in terms if term not in grown.terms]
        if reason := too_large(self.model, found):
            return Relaxation(reason=reason)
        if len(found) > 1:
            return Relaxation(tuple(found))
        only = found[0]
        return Relaxation((only,), declared=self._has_declared(only), earned=self._has_policy(only))

    def _has_declared(self, group: Group) -> bool:
        """Return whether a declared bound reads nothing but the group's variables."""
        if "upper" not in self.model.spans:
            return False
        return self.reader.of(self.model.upper, {}).entries <= _entries_of(group, self.reader)

    def _has_policy(self, group: Group) -> bool:
        """Return whether the table of one group can say what the default policy earns for ever."""
        model = self.model
        if model.lower is not None or model.horizon is not None or not model.history.is_empty:
            return False
        if group.states > limits.MAX_EARNED_ENTRIES:
            return False
        if model.policy is None:
            return True  # it reads what legality reads
        if model.policy.lets:
            return False
        reads = self.reader.of(model.policy.dist, {})
        return not reads.endless and reads.entries <= _entries_of(group, self.reader)

    # Growing groups ------------------------------------------------------------------------------

    def _grow(self, terms: list[Term]) -> Group | str:
        """Return the largest group that starts with the first term and takes what adds least; or why none."""
        first = self._closure([terms[0]])
        if first.reason:
            return f"{_name(terms[0])} {first.reason}"
        chosen, entries, rest = [terms[0]], first.entries, terms[1:]
        while rest:
            sized = [(self._bits(grown.entries), i, grown) for i, grown in self._wider(chosen, rest)]
            if not sized:
                break
            _, position, grown = min(sized, key=lambda found: found[:2])
            chosen.append(rest.pop(position))
            entries = grown.entries
        return self._group(chosen, entries)

    def _wider(self, chosen: list[Term], rest: list[Term]) -> Iterable[tuple[int, _Closure]]:
        for i, term in enumerate(rest):
            grown = self._closure([*chosen, term])
            if not grown.reason:
                yield i, grown

    def _group(self, terms: list[Term], entries: frozenset[Entry]) -> Group:
        questions = set(self.every.questions)
        for term in terms:
            questions |= self._term_reads(term).questions
        for entry in entries:
            questions |= self._entry_reads(entry).questions
        members: dict[str, list[int | None]] = {}
        for variable, member in sorted(entries, key=lambda e: (e[0], e[1] or 0)):
            members.setdefault(variable, []).append(member)
        parts = []
        for v in self.model.variables:
            if v.name in members and size_of(v.type) > 1:
                some = [m for m in members[v.name] if m is not None]
                whole = members[v.name] == self.reader.members(v.name)
                parts.append(Part(v, () if whole else tuple(some)))
        # Families first: what a step changes least varies slowest, so that a sweep settles most at once.
        parts.sort(key=lambda part: not part.variable.indices)
        return Group(tuple(terms), tuple(parts), alike(self.model.action, questions))

    def _closure(self, terms: Iterable[Term]) -> _Closure:
        """Return all entries that matter to the terms."""
        reads = Reads()
        reads.add(self.every)
        for term in terms:
            reads.add(self._term_reads(term))
        entries: set[Entry] = set()
        pending = sorted(reads.entries, key=str)
        endless = reads.endless
        while pending:
            entry = pending.pop()
            if entry in entries:
                continue
            entries.add(entry)
            if not is_finite(self.variables[entry[0]].type):
                return _Closure(frozenset(), f"depends on '{entry[0]}', whose values are not finitely many")
            if self._bits(entries) > math.log2(limits.MAX_GROUP_ENTRIES) + 1e-9:
                return _Closure(
                    frozenset(), f"depends on more than {limits.MAX_GROUP_ENTRIES} joint values of the state"
                )
            inner = self._entry_reads(entry)
            endless = endless or inner.endless
            pending.extend(inner.entries - entries)
        if endless:
            return _Closure(frozenset(), "depends on a draw from a continuous law")
        return _Closure(frozenset(entries))

    def _bits(self, entries: Iterable[Entry]) -> float:
        total = 0.0
        for name, member in entries:
            variable = self.variables[name]
            length = length_of(variable.indices if member is None else variable.indices[1:])
            total += math.log2(size_of(variable.type)) * length
        return total

    def _term_reads(self, term: Term) -> Reads:
        reward, member = term
        return self.reader.of(reward.value, self.reader.known(reward.binder, member))

    def _entry_reads(self, entry: Entry) -> Reads:
        """Return what the entry's next value depends on, and what is drawn along with it."""
        if entry not in self.reads:
            name, member = entry
            found = Reads()
            update = self.updates.get(name)
            for assign in () if update is None else update.assigns:
                drawn = "draws" in self.needs.of(assign.dist)
                if assign.variable == name or drawn:
                    binder = assign.binders[0] if member is not None else None
                    found.add(self.reader.of(assign.dist, self.reader.known(binder, member)))
                if drawn:
                    found.entries.add((assign.variable, member))
            self.reads[entry] = found
        return self.reads[entry]


def too_large(model: ir.Model, groups: Sequence[Group]) -> str:
    """Return why the groups' tables would take too long to fill, if they would."""
    declared = "upper" in model.spans
    most = limits.MAX_GROUPS_WORK if declared else limits.MAX_UNDECLARED_WORK
    work = sum(g.states * len(g.actions) for g in groups)
    if work <= most:
        return ""
    return (
        f"{len(groups)} tables of {max(g.states for g in groups)} entries and "
        f"{max(len(g.actions) for g in groups)} actions would take more than {most} steps to fill"
    )


def updated(group: Group, update: ElementUpdate) -> tuple[int, ...]:
    """Return the members of an element that an update changes for the group; (0,) stands for no family."""
    written = {a.variable for a in update.assigns}
    parts = [p for p in group.parts if p.variable.name in written]
    if not parts:
        return ()
    if update.element.binder is None:
        return (0,)
    if any(not p.members for p in parts):
        return tuple(range(update.members))
    return tuple(sorted({m for p in parts for m in p.members}))


def runs(positions: Iterable[int]) -> list[tuple[int, int]]:
    """Return ascending positions as ranges, both ends included."""
    found = []
    for _, run in groupby(enumerate(positions), key=lambda pair: pair[1] - pair[0]):
        members = [position for _, position in run]
        found.append((members[0], members[-1]))
    return found


def strides(positions: Sequence[int]) -> list[range]:
    """Return ascending positions as ranges: one where all are equally far from the next, else runs."""
    steps = {b - a for a, b in pairwise(positions)}
    if len(steps) == 1:
        return [range(positions[0], positions[-1] + 1, steps.pop())]
    return [range(first, last + 1) for first, last in runs(positions)]


def describe(group: Group) -> str:
    """Return the group's rewards in words: ``rover_exit, rock_sampled[0 .. 10]``."""
    found = []
    for name in dict.fromkeys(reward.name for reward, _ in group.terms):
        binder = next(reward.binder for reward, _ in group.terms if reward.name == name)
        members = sorted(m for reward, m in group.terms if reward.name == name and m is not None)
        if binder is None or len(members) == size_of(binder.type):
            found.append(name)
            continue
        low = low_of(binder.type)
        ends = (f"{low + a}" if a == b else f"{low + a} .. {low + b}" for a, b in runs(members))
        found.append(f"{name}[{', '.join(ends)}]")
    return ", ".join(found)


def _name(term: Term) -> str:
    reward, member = term
    return f"the reward '{reward.name}'" if member is None else f"a member's reward '{reward.name}'"


def _entries_of(group: Group, reader: Reader) -> set[Entry]:
    return {(p.variable.name, m) for p in group.parts for m in (p.members or reader.members(p.variable.name))}
