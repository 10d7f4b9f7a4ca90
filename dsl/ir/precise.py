# SPDX-License-Identifier: Apache-2.0
"""Draws with the text's own probabilities, for programs that have time for them."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import map_children

Part = TypeVar("Part", ir.Assign, ir.Observation, ir.Let)


def with_precise_draws(model: ir.Model) -> ir.Model:
    """Return the model with constant probabilities that have the masses of their texts, to 2^-64.

    An online planner draws with those of float32, where these are nearly the same: one 32-bit word decides
    then.
    """
    return replace(
        model,
        updates=tuple(map(_precise, model.updates)),
        inits=tuple(map(_precise, model.inits)),
        observations=tuple(map(_precise, model.observations)),
        lets=tuple(map(_precise, model.lets)),
    )


def _precise(part: Part) -> Part:
    return replace(part, dist=_draw(part.dist))


def _draw(dist: ir.Dist) -> ir.Dist:
    found = map_children(dist, lambda child: _draw(child) if isinstance(child, ir.Dist) else child)
    match found:
        case ir.Bernoulli(probability=p) | ir.Noisy(probability=p):
            return replace(found, probability=_constant(p))
        case ir.Table(entries=entries):
            return replace(found, entries=tuple((value, _constant(p)) for value, p in entries))
    return found


def _constant(p: ir.Expr) -> ir.Expr:
    return replace(p, precise=True) if isinstance(p, ir.Const) else p
