# SPDX-License-Identifier: Apache-2.0
"""Rewards by term: the interpreter takes a recorded step again, with the world's own draws."""

from __future__ import annotations

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.recordings.reader import RecordingError
from hypgen.recordings.recording import Header, Step, Variable

_DTYPES = {"bool": np.bool_, "float": np.float32, "int": np.int32, "named": np.int32}


def reward_terms(model: ir.Model, header: Header, step: Step) -> dict[str, float]:
    """Return what each reward term of a model earned in a step, in units of the reward.

    The model has the params of the recorded world. A draw is a function of seed, episode, step and place, so
    that the step is taken again as it was, and terms that read draws are right. ``RecordingError`` where the
    terms do not add up to the recorded reward: the model has other params, or a value cannot be read.
    """
    run = Interpreter(model)
    draws = PhiloxDraws(derive(header.options["seed"], Stream.WORLD, 0), step.episode, step.step)
    state: State = {v.name: _array(v, step) for v in header.variables}
    done = run.step(state, step.action, draws)
    reward = float(done.reward[0]) * 2.0**-model.reward_bits
    if reward != step.reward:
        raise RecordingError(
            f"step {step.step} of episode {step.episode} earned {step.reward:g}, "
            f"and with this model {reward:g}; give the model the params that it was recorded with"
        )
    terms = run.reward_terms(state, step.action, draws, done.after)
    return {name: float(fixed[0]) * 2.0**-model.reward_bits for name, fixed in terms.items()}


def _array(variable: Variable, step: Step) -> Array:
    """Return a variable's entries in one lane."""
    found = step.state[variable.name]
    values = found if isinstance(found, list) else [found]
    if variable.type == "named":
        codes = {name: code for code, name in enumerate(variable.values)}
        if unknown := [value for value in values if value not in codes]:
            raise RecordingError(f"{variable.name}: the recording does not tell the code of {unknown[0]!r}")
        values = [codes[value] for value in values]
    numbers = [np.nan if value is None else value for value in values]
    return np.asarray(numbers, _DTYPES[variable.type]).reshape(1, *variable.dims)
