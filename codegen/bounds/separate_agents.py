# SPDX-License-Identifier: Apache-2.0
"""Agents that act apart: together they earn at most what each earns alone with its share of the tokens.

A product action has a component for each agent. What an agent's variables become is its own affair: they are
updated from themselves and its component, without draws. A *token* is an entry of two values, the lower one
"spent" (a rock that is not good): it is updated without draws from itself and from conditions on one agent
each, the *atoms*, as are the rewards that read it. An agent acts alone while the others idle: do what leaves
tokens alone in every state. Who deals the valuable tokens of the state out among the agents in the best way
and adds what each can earn alone bounds what they earn together if each token passes the check in ``_holds``;
docs/internals/exact-models.md has the proof.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.flattening import Flattener, TooLarge, conjunction, conjuncts
from hypgen.codegen.passes.read_sets import Entry, Term, terms_of
from hypgen.dsl import ir
from hypgen.dsl.ir.evaluate import Known, Value, decided
from hypgen.dsl.ir.walk import map_children, shape, walk
from hypgen.dsl.types import BOOL, Bool, Type, is_finite, low_of, size_of


@dataclass(frozen=True)
class Team:
    """Agents that act apart.

    ``own``: the terms that each agent earns for itself. ``tokens``: each with the terms that depend on it.
    ``idle``: the code of an action's component that leaves tokens alone. ``variables``: of agents.
    """

    own: tuple[tuple[Term, ...], ...]
    tokens: tuple[tuple[Entry, tuple[Term, ...]], ...]
    idle: int
    variables: tuple[str, ...]

    @property
    def agents(self) -> int:
        """Return the number of agents."""
        return len(self.own)


def team_of(model: ir.Model) -> Team | str:
    """Return the model's team; what forbids one, or nothing where the action is no product."""
    indices = model.action.indices
    if not indices:
        return ""
    if len(indices) > 1 or size_of(indices[0]) != 2:
        return "there are not two agents"  # three would share tokens in 3^n ways
    try:
        return _Finder(model).team()
    except TooLarge:
        return "an expression is too large"


def legal_alone(model: ir.Model, team: Team, agent: int) -> ir.Expr:
    """Return what legality asks of one agent whatever the others do."""
    finder = _Finder(model, team.variables)
    try:
        legal = finder.flat.of(model.legal, {})
    except TooLarge:
        return ir.Const(BOOL, True)
    assert legal is not None
    return conjunction([part for part in conjuncts(legal) if finder.seen(part) == ({agent}, set())])


@dataclass(frozen=True)
class _Check:
    """A token's update and the terms that read it, as functions of its value and its atoms."""

    name: str
    type: Type
    next: ir.Expr
    rewards: tuple[ir.Expr, ...]
    atoms: tuple[tuple[int, ir.Expr], ...]  # and the agents that they are conditions on

    def idle(self, code: Value) -> tuple[Value | None, ...]:
        """Return what the atoms are where all components have this code, as far as that decides it."""
        return tuple(
            decided(atom, lambda e: code if isinstance(e, ir.ActionRead) else None) for _, atom in self.atoms
        )

    def holds(self, idle: Sequence[Value | None], agents: Sequence[int]) -> bool:
        """Return whether an owner of the token and others who hold it spent earn as much as all together.

        In every case: a spent token stays spent; where a step leaves the token valuable, any owner keeps it
        and they earn no less; where it does not, there is an owner that loses it with whom they earn no less.
        """
        for values in product((False, True), repeat=len(self.atoms)):
            for valuable in (False, True):
                together = self._outcome(valuable, values)
                owned, spent = (
                    [self._outcome(g, self._alone(values, idle, agent)) for agent in agents]
                    for g in (valuable, False)
                )
                if together is None or None in owned or any(o is None or o.kept for o in spent):
                    return False
                found = [self._bounds(together, owner, owned, spent) for owner in agents]
                if not (all(found) if together.kept else any(found)):
                    return False
        return True

    def _bounds(
        self,
        together: _Outcome,
        owner: int,
        owned: Sequence[_Outcome | None],
        spent: Sequence[_Outcome | None],
    ) -> bool:
        parts = [owned[i] if i == owner else other for i, other in enumerate(spent)]
        kept, earned = parts[owner], sum(part.reward for part in parts if part is not None)
        return kept is not None and kept.kept == together.kept and together.reward <= earned

    def _alone(self, values: Sequence[bool], idle: Sequence[Value | None], agent: int) -> list[Value | None]:
        return [
            value if acting == agent else none
            for (acting, _), value, none in zip(self.atoms, values, idle, strict=True)
        ]

    def _outcome(self, valuable: bool, atoms: Sequence[Value | None]) -> _Outcome | None:
        """Return what a step does; None where that is not decided."""
        known = {f"atom {number}": value for number, value in enumerate(atoms)}
        token = low_of(self.type) + valuable
        after = decided(self.next, self._knowing(known, token, token))
        if after is None:
            return None
        rewards = [decided(reward, self._knowing(known, token, after)) for reward in self.rewards]
        fixed = [round(reward * 2.0**24) for reward in rewards if reward is not None]
        return _Outcome(after != low_of(self.type), sum(fixed)) if len(fixed) == len(rewards) else None

    def _knowing(self, atoms: Mapping[str, Value | None], token: Value, after: Value) -> Known:
        """Return what reads give; nothing for agents' variables outside of atoms: ``x[0] != x[1]``."""

        def known(e: ir.Expr) -> Value | None:
            match e:
                case ir.Local(name=name):
                    return atoms.get(name)
                case ir.StateRead(variable=name, primed=primed) if name == self.name:
                    return after if primed else token
            return None

        return known


@dataclass(frozen=True)
class _Outcome:
    """Whether a token is valuable after a step, and what its terms earn, in fixed point."""

    kept: bool
    reward: int


class _Finder:
    def __init__(self, model: ir.Model, variables: Sequence[str] | None = None) -> None:
        self.model = model
        self.type = model.action.indices[0]
        self.agents = range(size_of(self.type))
        self.flat = Flattener(model, self.type)
        self.needs = NeedsAnalysis(model)
        self.updates = {u.variable: u for u in model.updates}
        self.families = {e.name: e.binder for e in model.elements if e.binder is not None}
        self.variables = set(self._agents_own() if variables is None else variables)

    def team(self) -> Team | str:
        own: tuple[list[Term], ...] = tuple([] for _ in self.agents)
        tokens: dict[Entry, list[Term]] = {}
        for reward in self.model.rewards:
            for term in terms_of(reward):
                agents, others = self.seen(value := self._value(reward.value, reward.binder, term[1]))
                if value is None or len(others) > 1 or (not others and len(agents) > 1):
                    return f"the reward '{reward.name}' depends on more than an agent or a token"
                if others:
                    tokens.setdefault(others.pop(), []).append(term)
                else:
                    own[min(agents, default=0)].append(term)
        checks = []
        for entry, terms in tokens.items():
            check = self._check(entry, terms)
            if isinstance(check, str):
                return check
            checks.append(check)
        idle = self._idle(checks)
        if isinstance(idle, str):
            return idle
        dealt = tuple((entry, tuple(terms)) for entry, terms in tokens.items())
        return Team(tuple(map(tuple, own)), dealt, idle, tuple(sorted(self.variables)))

    # What expressions read -----------------------------------------------------------------------

    def seen(self, e: ir.Expr | None) -> tuple[set[int], set[Entry]]:
        """Return which agents a written-out expression reads, and which entries that are no agent's."""
        agents: set[int] = set()
        others: set[Entry] = set()
        for node in () if e is None else walk(e):
            match node:
                case ir.StateRead(variable=name, indices=indices) if name in self.variables:
                    agents |= self._members(indices)
                case ir.ActionRead(indices=indices):
                    agents |= self._members(indices)
                case ir.StateRead(variable=name, indices=indices):
                    others |= self._entries(name, indices)
        return agents, others

    def _members(self, indices: tuple[ir.Expr, ...]) -> set[int]:
        if isinstance(indices[0], ir.Const):
            return {int(indices[0].value) - low_of(self.type)}
        return set(self.agents)

    def _entries(self, name: str, indices: tuple[ir.Expr, ...]) -> set[Entry]:
        variable = self.model.variable(name)
        binder = self.families.get(variable.element)
        if binder is None:
            return {(name, None)}
        if isinstance(indices[0], ir.Const):
            return {(name, int(indices[0].value) - low_of(binder.type))}
        return {(name, member) for member in range(size_of(binder.type))}

    def _value(self, e: ir.Expr | ir.Dist, binder: ir.Binder | None, member: int | None) -> ir.Expr | None:
        """Return ``e`` for a member, written out; None where it draws."""
        if "draws" in self.needs.of(e):
            return None
        known = {} if binder is None or member is None else {binder.name: _position(binder.type, member)}
        return self.flat.of(e, known)

    def _next(self, variable: str, member: int | None) -> ir.Expr | None:
        """Return what an entry becomes, written out; None where it draws."""
        update = self.updates.get(variable)
        if update is None:
            return _own_entry(self.model, variable, member)
        return self._value(update.dist, update.binders[0] if update.binders else None, member)

    def _agents_own(self) -> set[str]:
        """Return the variables with an entry for each agent that depends on the agent alone."""
        self.variables = {
            v.name
            for v in self.model.variables
            if v.element in self.families and self.families[v.element].type == self.type
        }
        while strange := {name for name in self.variables if not self._is_own(name)}:
            self.variables -= strange
        return self.variables

    def _is_own(self, name: str) -> bool:
        if len(self.model.variable(name).indices) > 1:
            return False
        for agent in self.agents:
            value = self._next(name, agent)
            agents, others = self.seen(value)
            if value is None or others or not agents <= {agent}:
                return False
        return True

    # The check of a token ------------------------------------------------------------------------

    def _check(self, entry: Entry, terms: Sequence[Term]) -> _Check | str:
        name, member = entry
        variable = self.model.variable(name)
        plain = len(variable.indices) == (member is not None) and is_finite(variable.type)
        if not plain or size_of(variable.type) != 2:
            return f"'{name}' is no single entry of two values"
        parts = [self._next(name, member)]
        parts += [self._value(reward.value, reward.binder, m) for reward, m in terms]
        atoms: list[tuple[int, ir.Expr]] = []
        whole = []
        for part in parts:
            if part is None or not self.seen(part)[1] <= {entry}:
                return f"'{name}' depends on draws or on more than agents and itself"
            whole.append(self._abstract(part, atoms))
        return _Check(name, variable.type, whole[0], tuple(whole[1:]), tuple(atoms))

    def _abstract(self, e: ir.Expr, atoms: list[tuple[int, ir.Expr]]) -> ir.Expr:
        """Return ``e`` with locals for its largest conditions on one agent, which are added to ``atoms``."""
        agents, others = self.seen(e)
        if isinstance(e, ir.Unary) and e.op == "not":
            return ir.Unary(BOOL, "not", self._abstract(e.operand, atoms))
        if isinstance(e.type, Bool) and len(agents) == 1 and not others:
            shapes = [shape(atom) for _, atom in atoms]
            if (key := shape(e)) not in shapes:
                atoms.append((min(agents), e))
                shapes.append(key)
            return ir.Local(BOOL, f"atom {shapes.index(key)}")
        return map_children(e, lambda child: self._abstract(child, atoms)) if agents else e

    def _idle(self, checks: Sequence[_Check]) -> int | str:
        """Return the first component that may stand for idling by all checks, or why there is none."""
        reason = ""
        tried = set()
        for code in range(size_of(self.model.action.type)):
            idle = [check.idle(_position(self.model.action.type, code).value) for check in checks]
            if (key := tuple(map(tuple, idle))) in tried:
                continue
            tried.add(key)
            failed = next((c for c, i in zip(checks, idle, strict=True) if not c.holds(i, self.agents)), None)
            if failed is None:
                return code
            reason = reason or f"'{failed.name}' is not as much to the agents apart as to all together"
        return reason


def _position(type_: Type, position: int) -> ir.Const:
    return ir.Const(type_, position + low_of(type_))


def _own_entry(model: ir.Model, name: str, member: int | None) -> ir.StateRead:
    variable = model.variable(name)
    indices = () if member is None else (_position(variable.indices[0], member),)
    return ir.StateRead(variable.type, name, indices)
