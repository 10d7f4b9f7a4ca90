# SPDX-License-Identifier: Apache-2.0
"""Joint values of a factor's hidden variables, as the arrays that a state holds for one member."""

from __future__ import annotations

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, State, from_position
from hypgen.dsl.types import length_of, size_of


def digits(model: ir.Model, factor: ir.Factor, value: int) -> dict[str, Array]:
    """Return the values of each of the factor's variables, for one member: a scalar or an array."""
    result: dict[str, Array] = {}
    for name in reversed(factor.variables):
        variable = model.variable(name)
        own = variable.indices if factor.binder is None else variable.indices[1:]
        size = size_of(variable.type)
        found = []
        for _ in range(length_of(own)):
            value, digit = divmod(value, size)
            found.append(digit)
        places = np.array(found[::-1]).reshape([size_of(t) for t in own])
        result[name] = from_position(places, variable.type)
    return result


def everywhere(model: ir.Model, factor: ir.Factor, value: int, state: State) -> State:
    """Return the state with the joint value in every member and lane."""
    result = dict(state)
    for name, values in digits(model, factor, value).items():
        result[name] = np.broadcast_to(values, state[name].shape).astype(state[name].dtype)
    return result
