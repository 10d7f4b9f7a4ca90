# SPDX-License-Identifier: Apache-2.0
"""Whether the belief about a float can be kept by its mean and deviation, and by those of which law."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl import ir
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.walk import Node, shape
from hypgen.dsl.types import FLOAT, Float

_KNOWN = (ir.Certain, ir.Table, ir.Normal, ir.UniformFloat, ir.Exponential)
_WORDS: dict[type[ir.Dist], str] = {
    ir.Truncated: "truncated(..)",
    ir.Clamped: "clamp(..)",
    ir.DrawIn: "a draw within a draw",
}


def moments_of(
    model: ir.Model, element: ir.Element, learnt: Sequence[tuple[str, Node]]
) -> tuple[ir.Moments | None, str]:
    """Return how the hidden float of a factor's member is kept, or why it is not.

    ``learnt`` has, in words and as law or condition, what the agent sees of the member in a step.
    """
    hidden = [v for v in model.variables if v.element == element.name and not v.visible]
    variable = hidden[0]
    if len(hidden) > 1:
        return None, f"'{hidden[0].name}' and '{hidden[1].name}' may depend on each other"
    if len(variable.indices) > (element.binder is not None):
        return None, f"'{variable.name}' is an array"
    init = next(i for i in model.inits if i.variable == variable.name)
    update = next((u for u in model.updates if u.variable == variable.name), None)
    for words, assign in (("init", init), ("update", update)):
        law = None if assign is None else _unknown(assign.dist)
        if law is not None:
            return None, f"the {words} of '{variable.name}' draws from '{_WORDS.get(type(law), 'a law')}'"
    still = update is None or _keeps(update)
    if not still:
        for words, node in learnt:
            if _reads_before(model, node, variable.name):
                return None, f"{words} reads '{variable.name}' as it was before the step"
    return ir.Moments(variable.name, still, _ends(model, variable, init, still)), ""


def _unknown(dist: ir.Dist) -> ir.Dist | None:
    """Return a law in ``dist`` whose mean and deviation take more than a formula."""
    match dist:
        case ir.IfDist(then=then, otherwise=otherwise):
            return _unknown(then) or _unknown(otherwise)
        case ir.LetDist(body=body):
            return _unknown(body)
    return None if isinstance(dist, _KNOWN) else dist


def _keeps(update: ir.Assign) -> bool:
    """Return whether the update leaves the variable as it is."""
    if not isinstance(update.dist, ir.Certain):
        return False
    own = tuple(ir.Local(b.type, b.name) for b in update.binders)
    return bool(shape(update.dist.value) == shape(ir.StateRead(FLOAT, update.variable, own)))


def _reads_before(model: ir.Model, node: Node, variable: str) -> bool:
    functions, lets = {f.name: f for f in model.functions}, {x.name: x for x in model.lets}
    return any(
        isinstance(found, ir.StateRead) and found.variable == variable and not (primed or found.primed)
        for found, primed in reached([node], functions, lets)
    )


def _ends(
    model: ir.Model, variable: ir.Variable, init: ir.Assign, still: bool
) -> tuple[ir.Expr, ir.Expr] | None:
    """Return the ends of a range that the variable never leaves, which read params only."""
    assert isinstance(variable.type, Float)
    if variable.type.prob:
        return ir.Const(FLOAT, 0.0), ir.Const(FLOAT, 1.0)
    if not still or not isinstance(init.dist, ir.UniformFloat):
        return None
    ends = init.dist.low, init.dist.high
    functions, lets = {f.name: f for f in model.functions}, {x.name: x for x in model.lets}
    read = (node for node, _ in reached(ends, functions, lets))
    return None if any(isinstance(node, ir.StateRead | ir.LetRead) for node in read) else ends
