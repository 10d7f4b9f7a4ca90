# SPDX-License-Identifier: Apache-2.0
"""The states of an enumerated model for formats and programs whose observations know less.

There the law of an observation may depend on the action and the next state alone. A next state whose
observation depends on the state before too is split, a copy for each law; copies differ in nothing else. An
action that is not legal does what the first legal one does.
"""

from __future__ import annotations

from hypgen.dsl.foreign.enumerated.dump import Enumerated, Outcome

ROUNDING = 1e-12  # what probabilities lack of 1 by no more than this is nothing
_DIGITS = 10  # to which laws are compared, so that rare entries count: they are quotients

Law = tuple[tuple[int, float], ...]  # (observation, probability)


class SplitStates:
    """Copies of states, numbered state after state, and what leads from one to another.

    ``copies[number]`` is (state, which of its copies); ``first[state]`` the number of a state's first.
    ``moves[state][action]`` are (next state, which of its copies, probability): what these lack of 1 ends the
    episode. ``rewards[state][action]`` is expected. ``ended`` says whether some episode ends.
    """

    def __init__(self, model: Enumerated) -> None:
        self.model = model
        actions = range(len(model.actions))
        rows = [_complete(of_state, len(actions)) for of_state in model.rows]
        self.ended = False
        self.rewards = [[reward for reward, _ in of_state] for of_state in rows]
        self._laws: list[list[list[Law]]] = [[[] for _ in actions] for _ in rows]
        self.moves = [
            [self._moves(action, outcomes) for action, (_, outcomes) in enumerate(of_state)]
            for of_state in rows
        ]
        self.first: list[int] = []
        self.copies: list[tuple[int, int]] = []
        for state, laws in enumerate(self._laws):
            self.first.append(len(self.copies))
            number = max(1, *(len(of_action) for of_action in laws))
            self.copies += [(state, copy) for copy in range(number)]

    def law(self, state: int, copy: int, action: int) -> Law | None:
        """Return the law of what is seen on arriving at a copy; None if the action never leads there."""
        laws = self._laws[state][action]
        return laws[min(copy, len(laws) - 1)] if laws else None

    def _moves(self, action: int, outcomes: list[Outcome]) -> list[tuple[int, int, float]]:
        """Return (next state, which of its copies, probability); what is seen there is noted as a law."""
        reached: dict[int, list[Outcome]] = {}
        for outcome in outcomes:
            reached.setdefault(outcome[1], []).append(outcome)
        result = []
        for following, ways in sorted(reached.items()):
            total = sum(p for _, _, p in ways)
            law = tuple((o, float(f"{p / total:.{_DIGITS}g}")) for o, _, p in sorted(ways))
            laws = self._laws[following][action]
            if law not in laws:
                laws.append(law)
            result.append((following, laws.index(law), total))
        if 1 - sum(p for _, _, p in result) > ROUNDING:
            self.ended = True
        return result


def _complete(
    rows: dict[int, tuple[float, list[Outcome]]], actions: int
) -> list[tuple[float, list[Outcome]]]:
    """Let every action do something."""
    first = rows[min(rows)] if rows else (0.0, [])
    return [rows.get(action, first) for action in range(actions)]
