# SPDX-License-Identifier: Apache-2.0
"""Writes an enumerated model in Cassandra's format.

An episode that ends goes to a state that is never left and earns nothing. An action that is not legal does
what the first legal one does.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from hypgen.dsl.foreign.enumerated.dump import Enumerated
from hypgen.dsl.foreign.enumerated.split_states import ROUNDING, Law, SplitStates

_ENDED = "ended"
_WORDS = """
discount values states actions observations start include exclude t o r uniform identity reset reward cost
"""
_KEYWORDS = frozenset(_WORDS.split())
_LONGEST_NAME = 60


class SeveralStartsError(Exception):
    """Episodes start visibly different, which the format cannot say."""


def export(model: Enumerated, origin: str) -> Iterator[str]:
    """Yield the lines of ``model``; raises ``SeveralStartsError``."""
    if len(model.starts) != 1:
        raise SeveralStartsError
    return _Exporter(model, origin).lines()


class _Exporter:
    def __init__(self, model: Enumerated, origin: str) -> None:
        self.model, self.origin = model, origin
        self.split = SplitStates(model)
        self.actions = range(len(model.actions))

    def lines(self) -> Iterator[str]:
        """Yield the whole file."""
        model = self.model
        self.states = _names([self._state_name(*c) for c in self.split.copies], "s")
        self.action_names = _names(model.actions, "a")
        self.observations = _names(model.observations, "o")
        yield f"# Cassandra's POMDP format, exported by hypgen: {self.origin}"
        yield f"# A state is named by its values: {', '.join(model.variables)}"
        if self.split.ended:
            yield f"# '{_ENDED}' follows the end of an episode."
        yield f"discount: {model.discount!r}"
        yield "values: reward"
        last = [_ENDED] if self.split.ended else []
        yield f"states: {' '.join([*self.states, *last])}"
        yield f"actions: {' '.join(self.action_names)}"
        yield f"observations: {' '.join([*self.observations, *last])}"
        yield from self._start()
        for action in self.actions:
            yield from self._action(action)
        if self.split.ended:
            yield f"T: * : {_ENDED} : {_ENDED} 1"
            yield f"O: * : {_ENDED} : {_ENDED} 1"

    def _state_name(self, state: int, copy: int) -> str:
        values = [{"true": "t", "false": "f"}.get(v, v) for v in self.model.values[state]]
        if self.model.steps:
            values.append(f"at{self.model.steps[state]}")
        name = "-".join(map(_plain, values))
        if len(name) > _LONGEST_NAME:
            name = f"s{state}"
        return f"{name}-again{copy}" if copy else name

    def _start(self) -> Iterator[str]:
        belief = {self.split.first[s]: p for s, p in self.model.starts[0]}
        if len(belief) == 1:
            yield f"start: {self.states[next(iter(belief))]}"
        elif max(belief.values()) - min(belief.values()) < ROUNDING:
            yield f"start include: {' '.join(self.states[s] for s in sorted(belief))}"
        else:
            numbers = [belief.get(s, 0.0) for s in range(len(self.states))] + [0.0] * self.split.ended
            yield f"start: {' '.join(map(_number, numbers))}"

    def _action(self, action: int) -> Iterator[str]:
        name = self.action_names[action]
        yield ""
        for number, (state, _) in enumerate(self.split.copies):
            left = 1.0
            for following, law, probability in self.split.moves[state][action]:
                left -= probability
                to = self.states[self.split.first[following] + law]
                yield f"T: {name} : {self.states[number]} : {to} {_number(probability)}"
            if left > ROUNDING:
                yield f"T: {name} : {self.states[number]} : {_ENDED} {_number(left)}"
        yield from self._sight(action)
        rewards = [self.split.rewards[state][action] for state, _ in self.split.copies]
        [(common, _)] = Counter(rewards).most_common(1)
        if common:
            yield f"R: {name} : * : * : * {_number(common)}"
            if self.split.ended:
                yield f"R: {name} : {_ENDED} : * : * 0"
        for number, reward in enumerate(rewards):
            if reward != common:
                yield f"R: {name} : {self.states[number]} : * : * {_number(reward)}"

    def _sight(self, action: int) -> Iterator[str]:
        """Yield what is seen after an action; where it leads nowhere that does not matter."""
        name = self.action_names[action]
        known: list[Law | None] = []
        for state, copy in self.split.copies:
            known.append(self.split.law(state, copy, action))
        different = set(known) - {None}
        common = next(iter(different), None) if len(different) == 1 else None
        if common is not None and not self.split.ended:
            yield from (f"O: {name} : * : {self.observations[o]} {_number(p)}" for o, p in common)
            return
        for number, law in enumerate(known):
            for seen, probability in law or common or ((0, 1.0),):
                what = self.observations[seen] if self.observations else _ENDED
                yield f"O: {name} : {self.states[number]} : {what} {_number(probability)}"


def _plain(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", text.replace("-", "m")).strip("_")


def _names(wanted: Sequence[str], letter: str) -> list[str]:
    """Return names that the format takes, each once."""
    taken: set[str] = {_ENDED}
    result = []
    for text in wanted:
        name = re.sub(r"[^A-Za-z0-9_-]+", "_", text).strip("_")
        if not re.match(r"[A-Za-z]", name):
            name = f"{letter}{name}"
        base, number = name, 2
        while name in taken or name.lower() in _KEYWORDS:
            name, number = f"{base}_{number}", number + 1
        taken.add(name)
        result.append(name)
    return result


def _number(number: float) -> str:
    """Return a number as text; of a probability 15 digits."""
    text = repr(float(f"{number:.15g}") if abs(number) < 1 else number)
    return text.removesuffix(".0")
