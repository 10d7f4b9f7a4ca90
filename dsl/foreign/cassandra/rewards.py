# SPDX-License-Identifier: Apache-2.0
"""The table R of Cassandra's format, which may have far too many entries to write out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

from hypgen.dsl.foreign.cassandra.tables import fields
from hypgen.dsl.foreign.cassandra.tokens import Tokens, Word
from hypgen.dsl.foreign.tables.foreign_model import Gain, Law, Read, Variable
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.messages import e09_cassandra

_ACTION, _STATE, _NEXT = Read("action"), Read("state"), Read("next")
_Key = tuple[int, ...]


class Rewards:
    """Specifications by which fields they leave open: the last that matches an entry gives its value."""

    def __init__(
        self, tokens: Tokens, actions: Variable, states: Variable, observations: Variable | None
    ) -> None:
        self.tokens = tokens
        seen = () if observations is None else (observations,)
        self.variables = (actions, states, states, *seen)
        # Which fields are given -> their values -> (order, value).
        self.given: dict[tuple[bool, ...], dict[_Key, tuple[int, float]]] = {}
        self.order = 0

    def read(self, heading: Word) -> bool:
        """Read a specification from behind its heading; return False after a mistake."""
        found = fields(self.tokens, self.variables)
        if found is None:
            return False
        rest = self.variables[len(found) :]
        if len(rest) > 2:
            word = self.tokens.peek()
            self.tokens.unexpected(word, "':' and a state")
            return False
        count = 1
        for variable in rest:
            count *= variable.size
        if not rest:
            if len(self.variables) == 3 and self._fourth_field():
                return False
            number = self.tokens.number("a reward")
            values = None if number is None else [number]
        else:
            form = " : ".join(
                ("R", "action", "state", "next state", "observation")[: 1 + len(self.variables)]
            )
            remedy = f"give the numbers that are missing; one reward is written `{form} number`"
            values = self.tokens.numbers(count, "R's " + ("row" if len(rest) == 1 else "matrix"), remedy)
        if values is None:
            return False
        for entry, value in zip(product(*(range(v.size) for v in rest)), values, strict=True):
            self._set([*found, *((e,) for e in entry)], value)
        return True

    def _fourth_field(self) -> bool:
        """Return whether an observation is named in a file without observations, and note it."""
        tokens = self.tokens
        word = tokens.next()
        is_field = tokens.text[: word.start].rstrip().endswith(":") and not tokens.at_heading()
        tokens.at = word.start
        if is_field:
            tokens.trouble.add(e09_cassandra.reward_sees_nothing(tokens.span(word)))
        return is_field

    def _set(self, found: Sequence[Sequence[int]], value: float) -> None:
        mask = tuple(len(f) != v.size for f, v in zip(found, self.variables, strict=True))
        self.order += 1
        table = self.given.setdefault(mask, {})
        key = tuple(f[0] if m else -1 for f, m in zip(found, mask, strict=True))
        table[key] = (self.order, value)

    def value(self, *entry: int) -> float:
        """Return the reward of an action, a state, the next state and what is observed."""
        best = (0, 0.0)
        for mask, table in self.given.items():
            key = tuple(e if m else -1 for e, m in zip(entry, mask, strict=True))
            best = max(best, table.get(key, best))
        return best[1]

    def gain(self, step: Law, sensor: Law | None, sign: float, notes: list[str]) -> Gain:
        """Return the expected reward: of (action, next state) if that says all, else of (action, state)."""
        actions, states = self.variables[0].size, self.variables[1].size
        reads = [any(mask[i] for mask in self.given) for i in range(len(self.variables))]
        sees = sensor if reads[3:] == [True] else None
        unseen = (0,) * (len(reads) - 3)
        varies = set()

        def after(action: int, state: int, following: int) -> float:
            if sees is None:
                return self.value(action, state, following, *unseen)
            row = sees.rows.at((action, following))
            values = [self.value(action, state, following, o) for o, _ in row]
            if min(values) == max(values):
                return values[0]
            varies.add("observations")
            return math.fsum(p * v for v, (_, p) in zip(values, row, strict=True))

        def expected(action: int, state: int) -> float:
            row = step.rows.at((action, state))
            values = [after(action, state, following) for following, _ in row]
            if min(values) == max(values):
                return values[0]
            varies.add("the next state")
            return math.fsum(p * v for v, (_, p) in zip(values, row, strict=True))

        if reads[1]:
            known = reads[2] or sees is not None
            of = (_ACTION, _STATE)
            values = [
                sign * (expected(a, s) if known else self.value(a, s, 0, *unseen))
                for a in range(actions)
                for s in range(states)
            ]
        else:
            of = (_ACTION, _NEXT)
            values = [sign * after(a, 0, s) for a in range(actions) for s in range(states)]
        notes += [
            f"Rewards on {what} are replaced by their expectation, which changes no value."
            for what in sorted(varies)
        ]
        return Gain("gain", of, Table.of((actions, states), [v + 0.0 for v in values]))  # no -0
