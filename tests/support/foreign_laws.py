# SPDX-License-Identifier: Apache-2.0
"""What a model's text and a file in Cassandra's format come to as arrays, by two ways that share nothing.

``laws_of_text`` evaluates the checked model with the interpreter's densities, ``laws_of_cassandra`` fills
dense arrays from the words of the file. T[a, s, s'], O[a, s', o] and the expected reward R[a, s].
"""

import re
from dataclasses import dataclass

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl import load as driver
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.messages.source import Source
from hypgen.dsl.types import low_of, size_of


@dataclass(frozen=True)
class Laws:
    """Arrays of a model with one state variable and at most one observation."""

    start: Array
    transitions: Array
    observations: Array | None
    rewards: Array

    def assert_close(self, other: "Laws", tolerance: float = 2e-6) -> None:
        """Compare all arrays."""
        np.testing.assert_allclose(self.start, other.start, atol=tolerance)
        np.testing.assert_allclose(self.transitions, other.transitions, atol=tolerance)
        if self.observations is not None and other.observations is not None:
            reached = self.transitions.sum(axis=1) > 0  # [a, s']
            seen, also = self.observations[reached], other.observations[reached]
            np.testing.assert_allclose(seen, also, atol=tolerance)
        np.testing.assert_allclose(self.rewards, other.rewards, rtol=1e-5, atol=1e-4)


def load(text: str) -> ir.Model:
    return driver.load("imported.pomdp", given=Source("imported.pomdp", text)).model


def laws_of_text(text: str) -> Laws:
    model = load(text)
    [variable] = model.variables
    states, actions = size_of(variable.type), model.action.count
    evaluator = Evaluator(model, {})
    a, s, n = (g.ravel() for g in np.meshgrid(*map(np.arange, (actions, states, states)), indexing="ij"))
    before, after = ({variable.name: v.astype(np.int32) + low_of(variable.type)} for v in (s, n))
    frame = Frame(np.arange(len(a)), before, after, a.astype(np.int32))

    def density(dist: ir.Dist, value: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.broadcast_to(evaluator.density(dist, frame, value), a.shape)

    shape = (actions, states, states)
    [update] = model.updates
    transitions = density(update.dist, after[variable.name]).reshape(shape)
    start = density(model.inits[0].dist, after[variable.name]).reshape(shape)[0, 0]
    observations = None
    if model.observations:
        [seen] = model.observations
        values = (np.int32(o + low_of(seen.type)) for o in range(size_of(seen.type)))
        observations = np.stack([density(seen.dist, v).reshape(shape)[:, 0] for v in values], axis=-1)
    earned = sum(np.broadcast_to(evaluator.value(r.value, frame), a.shape) for r in model.rewards)
    rewards = (transitions * np.asarray(earned, dtype=np.float64).reshape(shape)).sum(axis=2)
    return Laws(start, transitions, observations, rewards)


def laws_of_cassandra(text: str) -> Laws:
    """Read a file whose specifications are all well formed."""
    words = re.sub(r"#.*", "", text).replace(":", " : ").split()
    heads = [n for n, w in enumerate(words) if _is_head(words, n)]
    parts = [words[a:b] for a, b in zip(heads, [*heads[1:], len(words)], strict=True)]
    names: dict[str, list[str]] = {}
    for part in parts:
        if part[0] in ("states", "actions", "observations"):
            listed = part[2:]
            count = len(listed) == 1 and listed[0].isdigit()
            names[part[0]] = [str(i) for i in range(int(listed[0]))] if count else listed
    s, a, o = (len(names[k]) for k in ("states", "actions", "observations"))
    t, z, r = np.zeros((a, s, s)), np.zeros((a, s, o)), np.zeros((a, s, s, o))
    tables = {"T": (t, "ass"), "O": (z, "aso"), "R": (r, "asso")}
    letters = {"a": names["actions"], "s": names["states"], "o": names["observations"]}
    start = np.full(s, 1 / s)
    for part in parts:
        if part[0] in tables:
            table, axes = tables[part[0]]
            _assign(table, [letters[x] for x in axes], part[1:])
        elif part[0] == "start":
            start = _start(part[1:], letters["s"])
    sign = -1 if ["values", ":", "cost"] in [p[:3] for p in parts] else 1
    rewards = sign * np.einsum("ast,ato,asto->as", t, z, r)
    return Laws(start, t, z, rewards)


def _is_head(words: list[str], n: int) -> bool:
    heads = ("discount", "values", "states", "actions", "observations", "start", "T", "O", "R")
    behind = words[n + 1 : n + 3]
    if words[n] == "start" and behind[:1] in (["include"], ["exclude"]):
        return True
    # A colon before makes it a name, such as a state called R.
    return words[n] in heads and behind[:1] == [":"] and (n == 0 or words[n - 1] != ":")


def _values(word: str, names: list[str]) -> list[int]:
    if word == "*":
        return list(range(len(names)))
    return [names.index(word) if word in names else int(word)]


def _assign(table: Array, axes: list[list[str]], words: list[str]) -> None:
    chosen = []
    while words and words[0] == ":" and len(chosen) < len(axes):
        chosen.append(_values(words[1], axes[len(chosen)]))
        words = words[2:]
    words = [w for w in words if w != ":"]
    shape = [len(n) for n in axes[len(chosen) :]]
    if words == ["identity"]:
        block = np.eye(shape[0])
    elif words == ["uniform"]:
        block = np.full(shape, 1 / shape[-1])
    else:
        block = np.array([float(w) for w in words]).reshape(shape)
    table[np.ix_(*chosen)] = block


def _start(words: list[str], names: list[str]) -> Array:
    form, listed = words[0], words[1:] if words[0] == ":" else words[2:]
    result = np.zeros(len(names))
    if form == ":" and listed == ["uniform"]:
        result[:] = 1 / len(names)
    elif form == ":" and len(listed) == len(names) > 1:
        result[:] = [float(w) for w in listed]
    else:
        chosen = [i for w in listed for i in _values(w, names)]
        if form == "exclude":
            chosen = [i for i in range(len(names)) if i not in chosen]
        result[chosen] = 1 / len(chosen)
    return result
