# SPDX-License-Identifier: Apache-2.0
"""Which draws have too many outcomes to try them one by one: docs/internals/exact-models.md."""

from __future__ import annotations

from collections.abc import Iterator

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import children
from hypgen.dsl.messages import e08_parts
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span


def not_enumerable(model: ir.Model) -> tuple[Diagnostic, ...]:
    """Return, for each draw with too many outcomes to try them all, what to do about it."""
    return tuple(e08_parts.not_enumerable(name, span) for name, span in continuous_draws(model))


def continuous_draws(model: ir.Model) -> Iterator[tuple[str, Span]]:
    """Yield the draws with too many outcomes to try them all."""
    for name, dist, span in _draws(model):
        if is_continuous(dist):
            yield name, span


def _draws(model: ir.Model) -> Iterator[tuple[str, ir.Dist, Span]]:
    """Yield what may be drawn at the start or in a step, by the policy alone left out."""
    for assign in (*model.inits, *model.updates):
        yield assign.variable, assign.dist, assign.span
    for let in model.lets:
        yield let.name, let.dist, let.span
    for observation in model.observations:
        yield observation.name, observation.dist, observation.span


def sees_continuously(model: ir.Model) -> bool:
    """Return whether a digit of the observation key comes from a continuous law: it hardly ever repeats."""
    digits = {field.name for field in model.key}
    seen = (update.dist for update in model.updates if update.variable in digits)
    return any(map(is_continuous, (*(o.dist for o in model.observations), *seen)))


def is_continuous(node: ir.Dist) -> bool:
    """Return whether a distribution draws from a continuous law in some case."""
    if isinstance(node, ir.Binned):
        return False
    if isinstance(node, ir.Continuous):
        return True
    return any(is_continuous(child) for child in children(node) if isinstance(child, ir.Dist))
