# SPDX-License-Identifier: Apache-2.0
"""Solves an enumerated model with scikit-decide's SARSOP; ``sarsop.py`` starts it.

python benchmarks/exact/sarsop_domain.py FOLDER SECONDS GAP

Reads FOLDER/model.jsonl, which an exact program's --dump wrote. Writes the alpha vectors to FOLDER/policy,
for that program's --load-policy, and the bounds that SARSOP states to FOLDER/bounds.json.
"""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from policy_file import ClassVectors, policy_lines
from skdecide import DiscreteDistribution, EnumerableSpace, POMDPDomain, Value
from skdecide.hub.solver.sarsop import SARSOP

from hypgen.dsl.foreign.enumerated.dump import Enumerated, read
from hypgen.dsl.foreign.enumerated.split_states import ROUNDING, SplitStates


class Numbers(EnumerableSpace):
    """A finite set of numbers."""

    def __init__(self, numbers: Sequence[int]) -> None:
        self._numbers = tuple(numbers)

    def get_elements(self) -> Sequence[int]:
        """Return all."""
        return self._numbers

    def __getitem__(self, index: Any) -> Any:
        return self._numbers[index]

    def __len__(self) -> int:
        return len(self._numbers)


class EnumeratedDomain(POMDPDomain):
    """An enumerated model as scikit-decide wants it: states are numbers of copies, see ``SplitStates``.

    Behind them come the states once more as those of the start, where what is seen says which of several
    starts it is; `ended`, which is never left and earns nothing; and `before`, which leads to the start where
    the agent sees something there. No number is below 0: Python's hash of -1 is that of -2, and scikit-decide
    takes states of one hash for one.
    """

    T_state = T_observation = T_event = int
    T_value = float
    T_predicate = bool
    T_info = None

    def __init__(self, model: Enumerated) -> None:
        self.model = model
        self.split = SplitStates(model)
        self.start_at = len(self.split.copies)
        self.ended = self.start_at + len(model.rows)
        self.before = self.ended + 1
        self.start_of = {s: i for i, belief in enumerate(model.starts) for s, _ in belief}
        self.ended_seen = len(model.observations) + len(model.starts)

    @property
    def starts_differ(self) -> bool:
        """Return whether the agent sees something before its first action."""
        return len(self.model.starts) > 1

    def state_of(self, number: int) -> int:
        """Return the model's state of one of ours."""
        return number - self.start_at if number >= self.start_at else self.split.copies[number][0]

    def _starts(self) -> list[tuple[int, float]]:
        model = self.model
        return [
            (self.start_at + state, of_start * p)
            for of_start, belief in zip(model.start_probabilities, model.starts, strict=True)
            for state, p in belief
        ]

    def _get_action_space_(self) -> Numbers:
        return Numbers(range(len(self.model.actions)))

    def _get_applicable_actions_from(self, memory: int) -> Numbers:
        return Numbers(range(len(self.model.actions)))

    def _get_next_state_distribution(self, memory: int, action: int) -> Any:
        if memory == self.ended:
            return DiscreteDistribution([(self.ended, 1.0)])
        if memory == self.before:
            return DiscreteDistribution(self._starts())
        moves = self.split.moves[self.state_of(memory)][action]
        reached = [(self.split.first[state] + copy, p) for state, copy, p in moves]
        left = 1 - sum(p for _, p in reached)
        if left > ROUNDING:
            reached.append((self.ended, left))
        return DiscreteDistribution(reached)

    def _get_transition_value(self, memory: int, action: int, next_state: int | None = None) -> Any:
        away = memory >= self.ended
        return Value(reward=0.0 if away else self.split.rewards[self.state_of(memory)][action])

    def _is_transition_value_dependent_on_next_state_(self) -> bool:
        return False

    def _is_terminal(self, state: int) -> bool:
        return state == self.ended

    def _get_observation_space_(self) -> Numbers:
        return Numbers(range(self.ended_seen + 1))

    def _get_observation_distribution(self, state: int, action: int | None = None) -> Any:
        if self.start_at <= state < self.ended:
            seen = len(self.model.observations) + self.start_of[state - self.start_at]
            return DiscreteDistribution([(seen, 1.0)])
        law = None
        if state < self.start_at and action is not None:
            law = self.split.law(*self.split.copies[state], action)
        return DiscreteDistribution(list(law) if law else [(self.ended_seen, 1.0)])

    def _get_initial_state_distribution_(self) -> Any:
        if self.starts_differ:
            return DiscreteDistribution([(self.before, 1.0)])
        return DiscreteDistribution([(self.split.first[s], p) for s, p in self.model.starts[0]])


def vectors_of(domain: EnumeratedDomain, found: Sequence[Mapping[str, Any]]) -> list[ClassVectors]:
    """Return SARSOP's vectors restricted to each class of states that look alike."""
    model = domain.model
    classes = [ClassVectors([], []) for _ in range(max(model.classes) + 1)]
    for state, number in enumerate(model.classes):
        classes[number].states.append(state)
    for vector in found:
        values: dict[int, float] = {}
        for copy, value in vector["values"].items():
            if copy < domain.ended:
                values[domain.state_of(copy)] = value.reward  # copies of a state are worth the same
        least = min(values.values(), default=0.0)  # of states that SARSOP thinks impossible
        for of_class in classes:
            legal = model.rows[of_class.states[0]]
            if not legal:
                continue
            action = vector["action"] if vector["action"] in legal else min(legal)
            of_class.vectors.append((action, tuple(values.get(state, least) for state in of_class.states)))
    return classes


def main() -> None:
    """Solve what the command line says."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    folder, seconds, gap = Path(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    with (folder / "model.jsonl").open(encoding="utf-8") as lines:
        domain = EnumeratedDomain(read(lines))
    discount = domain.model.discount
    if discount >= 1:
        sys.exit("SARSOP needs a discount below 1")
    solver = SARSOP(lambda: domain, epsilon=gap, discount=discount, time_budget=max(1, int(seconds * 1000)))
    solver.solve()
    scale = 1 / discount if domain.starts_differ else 1.0
    classes = vectors_of(domain, solver.get_alpha_vectors())
    (folder / "policy").write_text("".join(policy_lines(domain.model.policy_hash, classes)))
    bounds = {
        "lower": solver.get_lower_bound() * scale,
        "upper": solver.get_upper_bound() * scale,
        "vectors": solver.get_nb_alpha_vectors(),
        "beliefs": solver.get_nb_explored_beliefs(),
        "seconds": solver.get_solving_time() / 1000,
    }
    (folder / "bounds.json").write_text(json.dumps(bounds))


if __name__ == "__main__":
    main()
