# SPDX-License-Identifier: Apache-2.0
"""Rewards by term: the interpreter takes a recorded step again, with the world's own draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, State
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.value_text import value_text
from hypgen.dsl.types import Enum, size_of
from hypgen.recordings.reader import RecordingError
from hypgen.recordings.recording import Header, Step, Variable

_DTYPES = {"bool": np.bool_, "float": np.float32, "int": np.int32, "named": np.int32}


def params_of(model: ir.Model, header: Header) -> dict[str, Any]:
    """Return the params of a recorded world as ``Interpreter`` takes them: enums by their codes.

    ``RecordingError`` where the header lacks one, or has it with a value that the model does not know.
    """
    found = {}
    for param in model.params:
        try:
            given = header.params[param.name]
            if isinstance(param.type, Enum):
                codes = {value_text(code, param.type): code for code in range(size_of(param.type))}
                given = [codes[name] for name in (given if isinstance(given, list) else [given])]
            found[param.name] = given
        except KeyError as error:
            raise RecordingError(f"the recording does not tell the param {param.name} ({error})") from None
    return found


def reward_terms(model: ir.Model, header: Header, step: Step) -> dict[str, float]:
    """Return what each reward term of a model earned in a step, in units of the reward.

    A draw is a function of seed, episode, step and place, so
    that the step is taken again as it was, and terms that read draws are right. ``RecordingError`` where the
    terms do not add up to the recorded reward, and where a value cannot be read.
    """
    run = Interpreter(model, params_of(model, header))
    draws = PhiloxDraws(derive(header.options["seed"], Stream.WORLD, 0), step.episode, step.step)
    state: State = {v.name: _array(v, step) for v in header.variables}
    done = run.step(state, step.action, draws)
    reward = float(done.reward[0]) * 2.0**-model.reward_bits
    if reward != step.reward:
        raise RecordingError(
            f"step {step.step} of episode {step.episode} earned {step.reward:g}, "
            f"and with this model {reward:g}"
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
