# SPDX-License-Identifier: Apache-2.0
"""The bound of a model's rewards: groups of all agents together, or of agents that act apart."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from hypgen.codegen.bounds.groups import Group, Part, Relaxation, grow, too_large
from hypgen.codegen.bounds.separate_agents import Team, legal_alone, team_of
from hypgen.codegen.layout import limits
from hypgen.codegen.passes.read_sets import Entry, Reader, Reads, Term, alike
from hypgen.dsl import ir
from hypgen.dsl.types import is_finite, length_of, size_of


def relax(model: ir.Model) -> Relaxation:
    """Return the groups of the model's rewards: agents apart where all together are no single group."""
    found = grow(model)
    if found.exact or model.discount == 1:
        return found
    team = team_of(model)
    if isinstance(team, str):
        return replace(found, together=team)
    groups = _Dealer(model, team).groups()
    if isinstance(groups, str):
        return replace(found, together=groups)
    if reason := too_large(model, groups):
        return replace(found, together=reason)
    return Relaxation(tuple(groups), team=team)


class _Dealer:
    """Deals a team's tokens to groups of each agent."""

    def __init__(self, model: ir.Model, team: Team) -> None:
        self.model = model
        self.team = team
        self.reader = Reader(model)
        self.updates = {u.variable: u for u in model.updates}
        self.legal = [self.reader.of(legal_alone(model, team, agent), {}) for agent in range(team.agents)]

    def groups(self) -> list[Group] | str:
        """Return the groups, or why there are none: as many tokens in each as fit, dealt one by one.

        So neighbours in the model's order come to different groups: those a way apart leave it to be walked.
        """
        agents = range(self.team.agents)
        terms = [term for _, found in self.team.tokens for term in found]
        alone = [self._parts([*terms, *self.team.own[agent]], agent) for agent in agents]
        for variable in (part.variable for parts in alone for part in parts):
            if not is_finite(variable.type):
                return f"an agent depends on '{variable.name}', whose values are not finitely many"
        cells = max(math.prod(size_of(p.variable.type) for p in parts) for parts in alone)
        most = min(int(math.log2(max(limits.MAX_GROUP_ENTRIES // cells, 1))), limits.MAX_SHARED_TOKENS)
        if self.team.tokens and most < 1:
            return f"an agent depends on more than {limits.MAX_GROUP_ENTRIES // 2} joint values of the state"
        count = max(1, -(-len(self.team.tokens) // max(most, 1)))
        found = []
        for first in range(count):
            dealt = self.team.tokens[first::count]
            for agent in agents:
                # What agents earn for themselves counts once: with the last group.
                own = self.team.own[agent] if first == count - 1 else ()
                terms = [*own, *(term for _, found in dealt for term in found)]
                parts = (*self._tokens([entry for entry, _ in dealt]), *alone[agent])
                found.append(Group(tuple(terms), parts, self._actions(terms, dealt, parts, agent)))
        return found

    def _tokens(self, entries: Sequence[Entry]) -> tuple[Part, ...]:
        parts = []
        for variable in self.model.variables:
            members = tuple(sorted(m or 0 for name, m in entries if name == variable.name))
            if members:
                whole = len(members) == length_of(variable.indices)
                parts.append(Part(variable, () if whole else members))
        return tuple(parts)

    def _parts(self, terms: Iterable[Term], agent: int) -> tuple[Part, ...]:
        """Return the agent's variables on which the terms depend."""
        reads = Reads()
        reads.add(self.legal[agent])
        for reward, member in terms:
            reads.add(self.reader.of(reward.value, self.reader.known(reward.binder, member)))
        pending = {name for name, _ in reads.entries}
        for (name, member), _ in self.team.tokens:
            pending |= {name for name, _ in self._update((name, member)).entries}
        found: set[str] = set()
        while pending:
            name = pending.pop()
            if name in self.team.variables and name not in found:
                found.add(name)
                pending |= {inner for inner, _ in self._update((name, agent)).entries}
        return tuple(Part(v, (agent,)) for v in self.model.variables if v.name in found)

    def _update(self, entry: Entry) -> Reads:
        name, member = entry
        update = self.updates.get(name)
        if update is None:
            return Reads()
        binder = update.binders[0] if update.binders else None
        return self.reader.of(update.dist, self.reader.known(binder, member))

    def _actions(
        self,
        terms: Iterable[Term],
        dealt: Sequence[tuple[Entry, tuple[Term, ...]]],
        parts: Sequence[Part],
        agent: int,
    ) -> tuple[int, ...]:
        """Return joint actions in which the other agents idle, those that differ for the agent."""
        questions = set(self.legal[agent].questions)
        for reward, member in terms:
            questions |= self.reader.of(reward.value, self.reader.known(reward.binder, member)).questions
        entries = [entry for entry, _ in dealt]
        entries += [(p.variable.name, agent) for p in parts if p.variable.name in self.team.variables]
        for entry in entries:
            questions |= self._update(entry).questions
        size = size_of(self.model.action.type)
        codes = alike(replace(self.model.action, indices=()), questions)
        place = self.team.agents - 1 - agent  # the first component is the most significant
        idle = sum(self.team.idle * size**i for i in range(self.team.agents) if i != place)
        return tuple(idle + code * size**place for code in codes)
