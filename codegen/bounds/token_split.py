# SPDX-License-Identifier: Apache-2.0
"""The small models of agents that act apart, as C++: what one may do, and how they share tokens best."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.codegen.bounds.group_functions import GroupFunctions, less_of_both, on_host
from hypgen.codegen.bounds.groups import Part, Relaxation
from hypgen.codegen.bounds.separate_agents import legal_alone
from hypgen.codegen.layout.state_layout import Field
from hypgen.codegen.model.interface import PLACE, Interface
from hypgen.codegen.tree.expr import FALSE, Expr, call, cast, member, of
from hypgen.codegen.tree.statements import Function, assign, const, var


class TeamFunctions(GroupFunctions):
    """Builds what bounds the rewards of a team: groups of one agent each, which share tokens."""

    def __init__(self, interface: Interface, relaxation: Relaxation, fields: Sequence[Field]) -> None:
        super().__init__(interface, relaxation, fields)
        assert relaxation.team is not None
        self.team = relaxation.team
        self.agents = range(self.team.agents)
        self.shares = range(len(self.groups) // self.team.agents)
        unique = self.context.names.struct.unique
        self.legal = [unique(f"is_legal_for_agent_{agent}") for agent in self.agents]
        self.rows = [unique(f"row_of_agent_{agent}") for agent in self.agents]
        self.tokens = [unique(f"tokens_of_share_{share}") for share in self.shares]

    def all(self) -> list[Function]:
        """Return the functions of all groups."""
        found = [self._legal_alone(agent) for agent in self.agents]
        found += super().all()
        for agent in self.agents:
            comment = f"// What agent {agent}'s rows of tables stand for."
            found.append(self._index(self._parts(agent)[1], self.rows[agent], comment))
        for share in self.shares:
            tokens = self._parts(share * self.team.agents)[0]
            found.append(self._index(tokens, self.tokens[share], "// Which tokens are valuable."))
        return found

    def upper(self) -> Function:
        """Return ``upper``: the declared bound or what the agents are worth apart, whichever is less."""
        builder = self.interface.given(PLACE)
        for agent in self.agents:
            row = call(self.rows[agent], "fixed", "state")
            builder.code.add(const("std::int32_t", f"row_{agent}", row))
        for share in self.shares:
            tables = (self.groups[share * self.team.agents + agent].table for agent in self.agents)
            rows = [
                member("params", table) + of(f"row_{agent}") * self._sets(share)
                for agent, table in zip(self.agents, tables, strict=True)
            ]
            tokens = cast("std::uint32_t", call(self.tokens[share], "fixed", "state"))
            best = call("relaxation::best_share", *rows, tokens)
            builder.code.add(assign("bound", best, "+=") if share else var("float", "bound", best))
        less_of_both(builder.code)
        return builder.done("float", "upper")

    def _parts(self, number: int) -> tuple[list[Part], list[Part]]:
        """Return the parts of a group that are tokens and those that are its agent's."""
        parts = self.groups[number].group.parts
        own = [part for part in parts if part.variable.name in self.team.variables]
        return [part for part in parts if part not in own], own

    def _sets(self, share: int) -> int:
        """Return the number of sets of a share's tokens."""
        return 1 << sum(part.entries for part in self._parts(share * self.team.agents)[0])

    def _legal_alone(self, agent: int) -> Function:
        builder = self.interface.acting([*PLACE, ("int", "action")])
        builder.value(legal_alone(self.context.model, self.team, agent))
        comment = f"// What is legal for agent {agent} whatever the other does."
        return on_host(builder.done("bool", self.legal[agent], [comment]))

    def _may_stop(self) -> bool:
        return True  # one agent may be done before the other, which ends no episode

    def _ends(self) -> Expr:
        return FALSE

    def _legal(self, number: int) -> str:
        return self.legal[number % self.team.agents]

    def _rows(self, number: int) -> int:
        # A row for each place of the agent, so that the sets of tokens that it may have lie side by side.
        return self.groups[number].group.states // self._sets(number // self.team.agents)
