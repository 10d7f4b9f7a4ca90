# SPDX-License-Identifier: Apache-2.0
"""Fitting a distribution to the type that its place asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.check.scope.let_bindings import let_dist
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import e03_types, e06_ranges
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Enum, Float, Int, Type

_WITH_OWN_RANGE = ir.Noisy | ir.UniformInt | ir.Counted | ir.Weighted


def fitted(dist: ir.Dist, target: Type | None, span: Span, what: str) -> ir.Dist:
    """Return ``dist``, whose type is its own, over ``target`` (None: as it is)."""
    if target is None or target == dist.type:
        return dist
    if isinstance(target, Int) and isinstance(dist.type, Int):
        require_range(dist.type, target, span, what)
    elif not (isinstance(target, Float) and isinstance(dist.type, Float)):
        raise refused(target, dist.type, span, what)
    return widened(dist, target)


def require_range(found: Int, target: Int, span: Span, what: str) -> None:
    """Raise unless all ints that a draw can give lie in the range asked for."""
    if found.low < target.low or target.high < found.high:
        raise Mistake(e06_ranges.draw_outside_range(what, found, target, span))


def refused(target: Type, found: Type, span: Span, what: str) -> Mistake:
    """Return the mistake of a draw of numbers where something else is needed."""
    if not isinstance(found, Int | Float):
        return Mistake(e03_types.mismatch(what, target, found, span))
    return Mistake(e03_types.draw_of_numbers(what, target, found, span))


def joined(branches: list[tuple[ir.Dist, Span]], what: str) -> list[ir.Dist]:
    """Return branches of one type, which is what they have in common."""
    if any(isinstance(dist.type, Float) for dist, _ in branches):
        branches = [(_as_float(dist), span) for dist, span in branches]
    common = branches[0][0].type
    for dist, span in branches[1:]:
        found = operators.join(common, dist.type)
        if found is None:
            raise Mistake(e03_types.mismatch(what, common, dist.type, span))
        common = found
    return [widened(dist, common) for dist, _ in branches]


def _as_float(dist: ir.Dist) -> ir.Dist:
    if isinstance(dist, ir.Certain) and isinstance(dist.type, Int):
        value = operators.to_float(dist.value)
        return ir.Certain(value.type, value)
    return dist


def widened(dist: ir.Dist, t: Type) -> ir.Dist:
    """Return ``dist`` over a type with more values."""
    if dist.type == t:
        return dist
    match dist:
        case ir.Certain(_, value):
            return ir.Certain(t, value)
        case ir.IfDist(_, condition, then, otherwise):
            return ir.IfDist(t, condition, widened(then, t), widened(otherwise, t))
        case ir.LetDist(_, name, value, body):
            return ir.LetDist(t, name, value, widened(body, t))
        case ir.DrawIn(_, name, law, body):
            return ir.DrawIn(t, name, law, widened(body, t))
        case ir.Table():
            return replace(dist, type=t)
        case ir.UniformSet(otherwise=otherwise):
            return replace(dist, type=t, otherwise=None if otherwise is None else widened(otherwise, t))
        case ir.Uniform(own):
            return uniform_over(own, t)
        case ir.Widened(_, inner):
            return widened(inner, t)
        case ir.Continuous():
            return replace(dist, type=t)
        case _ if isinstance(dist, _WITH_OWN_RANGE):
            return ir.Widened(t, dist)
    raise AssertionError(dist)


def in_variant(dist: ir.Dist, enum: Enum, variant: str) -> ir.Dist:
    """Return the variant of ``enum`` whose argument ``dist`` draws."""

    def of_value(value: ir.Expr) -> ir.Expr:
        return operators.make_variant(enum, variant, value)

    def of(inner: ir.Dist) -> ir.Dist:
        return in_variant(inner, enum, variant)

    match dist:
        case ir.Certain(value=value):
            return ir.Certain(enum, of_value(value))
        case ir.IfDist(_, condition, then, otherwise):
            return ir.IfDist(enum, condition, of(then), of(otherwise))
        case ir.LetDist(_, name, value, body):
            return ir.LetDist(enum, name, value, of(body))
        case ir.DrawIn(_, name, law, body):
            return ir.DrawIn(enum, name, law, of(body))
        case ir.Table(entries=entries, rest=rest):
            values = tuple((of_value(value), p) for value, p in entries)
            return replace(dist, type=enum, entries=values, rest=None if rest is None else of_value(rest))
        case ir.UniformSet(value=value, otherwise=otherwise):
            left = None if otherwise is None else of(otherwise)
            return replace(dist, type=enum, value=of_value(value), otherwise=left)
    return ir.InVariant(enum, variant, dist)


def uniform_over(own: Type, target: Type) -> ir.Dist:
    """Return the uniform draw from ``own`` as a distribution over ``target``, which may be wider."""
    if own == target:
        return ir.Uniform(own)
    return ir.UniformSet(target, (ir.Binder("value_1", own),), None, ir.Local(own, "value_1"), None)


def changed(dist: ir.Dist, change: Callable[[ir.Dist], ir.Dist]) -> ir.Dist:
    """Return ``dist`` with each of the distributions that it chooses from changed."""
    match dist:
        case ir.IfDist(_, condition, then, otherwise):
            a, b = changed(then, change), changed(otherwise, change)
            common = operators.join(a.type, b.type)
            assert common is not None
            return ir.IfDist(common, condition, widened(a, common), widened(b, common))
        case ir.LetDist(_, name, value, body):
            inner = changed(body, change)
            return let_dist(name, value, inner)
        case ir.DrawIn(_, name, law, body):
            inner = changed(body, change)
            return ir.DrawIn(inner.type, name, law, inner)
        case ir.Widened(_, inner):
            return changed(inner, change)
    return change(dist)
