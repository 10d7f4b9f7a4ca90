# SPDX-License-Identifier: Apache-2.0
"""A run of a model, step by step: the table that ``--trace`` of a generated program writes too.

docs/internals/contracts.md says how lanes act; ``columns`` names the columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive, philox
from hypgen.dsl.interpret.floats.scalar_functions import canonical_bits, canonical_double_bits
from hypgen.dsl.interpret.interpreter import Interpreter, pick_legal
from hypgen.dsl.interpret.posteriors import Posterior
from hypgen.dsl.ir import key_digits
from hypgen.dsl.types import size_of

_ACTION_SITE = 0xAC7


def columns(model: ir.Model) -> list[str]:
    """Return the names of the columns of a trace."""
    flat = [
        v.name + "".join(f"[{i}]" for i in place)
        for v in model.variables
        for place in np.ndindex(*(size_of(t) for t in v.indices))
    ]
    known = [
        f"posterior {f.element}[{i}]"
        for f in model.factors
        if f.exact
        for i in range(f.members * (1 if f.size == 2 else f.size))
    ]
    words = key_digits.word_count(model.key)
    key = ["key"] if words == 1 else [f"key[{i}]" for i in range(words)]
    before = ["policy", "action", "reward", "terminal", "success"]
    return [
        *flat,
        *known,
        *(["first"] if model.first_seen else []),
        *before,
        *key,
        "upper",
        "tail",
        "lower",
        "density",
        "weight",
        *(f"filter {name}" for name in flat),
    ]


def trace(
    model: ir.Model,
    seed: int,
    scenarios: int,
    steps: int,
    params: Mapping[str, Sequence[Any] | Any] | None = None,
) -> npt.NDArray[np.int64]:
    """Return the table of ``steps`` random steps: one row for each step and scenario, step-major."""
    interpreter = Interpreter(model, params, lanes=scenarios)
    world, own = derive(seed, Stream.TEST, 0), derive(seed, Stream.TEST, 1)
    lanes = np.arange(scenarios)
    state = _start(interpreter, PhiloxDraws(world, lanes, 0))
    history = interpreter.init_history(state)
    posterior = interpreter.init_posterior(state)
    rows: list[Array] = []
    for t in range(steps):
        draws = PhiloxDraws(world, lanes, t)
        policy = interpreter.default_policy(state, draws, history)
        word = philox(world, (lanes, t, _ACTION_SITE, 0))[0]
        action = pick_legal(interpreter.legal_actions(state), word)
        stuck = action < 0
        taken = np.where(stuck, 0, action)
        after, reward, terminal, success, _ = interpreter.step(state, taken, draws)
        ended = stuck | terminal
        key = np.where(ended[:, np.newaxis], np.uint64(0), interpreter.observe(state, taken, draws, after))
        weight, filtered = interpreter.filter(state, taken, key, PhiloxDraws(own, lanes, t))
        bounds = [interpreter.upper(state), interpreter.tail(state), interpreter.lower(state, history)]
        rows.append(
            np.column_stack(
                [
                    *(
                        _flatten(model, state, scenarios),
                        _probabilities(model, posterior, scenarios),
                        *(
                            [canonical_double_bits(interpreter.init_likelihood(state)).view(np.int64)]
                            if model.first_seen
                            else []
                        ),
                        policy,
                        action,
                    ),
                    *(np.where(stuck, 0, x).astype(np.int64) for x in (reward, terminal, success)),
                    key.view(np.int64),
                    *(np.where(stuck, 0, canonical_bits(x)).astype(np.int64) for x in bounds),
                    *(
                        np.where(ended, 0, canonical_double_bits(x).view(np.int64))
                        for x in (interpreter.observation_density(state, taken, key, draws, after), weight)
                    ),
                    np.where(ended[:, np.newaxis], 0, _flatten(model, filtered, scenarios)),
                ]
            )
        )
        restarted = _start(interpreter, PhiloxDraws(world, lanes, t + 1)) if ended.any() else after
        advanced = interpreter.advance_history(state, taken, key, after, history)
        begun = interpreter.init_history(restarted)
        learnt, _ = interpreter.advance_posterior(state, taken, key, after, posterior)
        fresh = interpreter.init_posterior(restarted)
        posterior = {name: _select(ended, fresh[name], learnt[name]) for name in learnt}
        history = {name: _select(ended, begun[name], advanced[name]) for name in advanced}
        state = {name: _select(ended, restarted[name], after[name]) for name in after}
    return np.concatenate(rows) if rows else np.zeros((0, len(columns(model))), dtype=np.int64)


def _start(interpreter: Interpreter, draws: PhiloxDraws) -> State:
    return interpreter.init_hidden(interpreter.init_visible(draws), draws)


def _flatten(model: ir.Model, state: State, lanes: int) -> Array:
    parts = [_exported(state[v.name]).reshape(len(state[v.name]), -1) for v in model.variables]
    return np.concatenate(parts, axis=1) if parts else np.zeros((lanes, 0), dtype=np.int64)


def _probabilities(model: ir.Model, posterior: Posterior, lanes: int) -> Array:
    """Return the numbers that a solver keeps: of two values, the second's probability."""
    parts = [np.zeros((lanes, 0), dtype=np.int64)]
    for factor in model.factors:
        if factor.exact:
            values = posterior[factor.element][..., 1 if factor.size == 2 else 0 :]
            parts.append(canonical_double_bits(values.reshape(lanes, -1)).view(np.int64))
    return np.concatenate(parts, axis=1)


def _exported(values: Array) -> Array:
    """Return values as a solver exports them: ints, and floats as the int32 of the same bits."""
    if values.dtype == np.float32:
        values = canonical_bits(values).view(np.int32)
    return values.astype(np.int64)


def _select(condition: Array, then: Array, otherwise: Array) -> Array:
    return np.where(condition.reshape(-1, *(1,) * (then.ndim - 1)), then, otherwise)
