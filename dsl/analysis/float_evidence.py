# SPDX-License-Identifier: Apache-2.0
"""Whether floats that the agent sees can weigh a belief.

A continuous law has a density, and values of their own (``=``, tables) have probabilities. A value that
follows from a hidden float has neither: no two particles agree on it. Nor can both be compared, so hidden
state may not choose between them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Reach, Uses
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.messages import e05_reads
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.report import Mistake, Report
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Float

# What says how likely a value is: a probability, a density, or both, of a law between two ends.
_Kind: TypeAlias = str | tuple[float, float]


@dataclass(frozen=True)
class Shown:
    """A float that the agent sees: in a step, or at the start; ``what`` says so in words."""

    owner: Owner
    what: str
    dist: ir.Dist
    span: Span


@dataclass(frozen=True)
class _Fault:
    """The names by which a value (or a ``choice`` of a law) follows from what the agent does not know."""

    names: frozenset[str]
    choice: bool


def check_floats(
    shown: list[Shown],
    variables: Mapping[str, ir.Variable],
    functions: Mapping[str, ir.Function],
    lets: Mapping[str, ir.Let],
    uses: Uses,
    report: Report,
) -> None:
    """Report the floats among what the agent sees that cannot weigh a belief."""
    for one in shown:
        if not isinstance(one.dist.type, Float):
            continue
        fault = next(_Laws(variables, functions, lets).faults(one.dist), None)
        if fault is not None:
            report.add(Mistake(_diagnostic(one, fault, uses)))


def _diagnostic(shown: Shown, fault: _Fault, uses: Uses) -> Diagnostic:
    reads: list[Reach] = uses.closure(shown.owner)
    cause = next(r for r in reads if r.name in fault.names and r.kind in ("variable", "draw"))
    route = cause.route(str(shown.owner))
    if fault.choice:
        return e05_reads.choice_of_densities(shown.what, route, cause.span, shown.span)
    if shown.owner.kind == "init":
        return e05_reads.first_float(shown.what, route, cause.span, shown.span)
    return e05_reads.weighed_float(shown.what, route, cause.span, shown.span)


@dataclass(frozen=True)
class _Laws:
    """The laws of a model: ``locals`` are those that follow from what the agent does not know."""

    variables: Mapping[str, ir.Variable]
    functions: Mapping[str, ir.Function]
    lets: Mapping[str, ir.Let]
    locals: Mapping[str, frozenset[str]] = field(default_factory=dict)

    def faults(self, dist: ir.Dist) -> Iterator[_Fault]:
        """Yield what keeps a law from weighing a belief."""
        match dist:
            case ir.Certain(value=value):
                yield from self._values(value)
            case ir.Table(entries=entries, rest=rest):
                for value, _ in entries:
                    yield from self._values(value)
                if rest is not None:
                    yield from self._values(rest)
            case ir.UniformSet(condition=condition, value=value, otherwise=otherwise):
                yield from self._values(value)
                if otherwise is not None:
                    yield from self.faults(otherwise)
                    yield from self._choices(condition, {"value", *_kinds(otherwise)})
            case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
                yield from self.faults(then)
                yield from self.faults(otherwise)
                yield from self._choices(condition, {*_kinds(then), *_kinds(otherwise)})
            case ir.LetDist(name=name, value=value, body=body):
                inner = replace(self, locals={**self.locals, name: self._unknown(value, floats=False)})
                yield from inner.faults(body)

    def _values(self, value: ir.Expr) -> Iterator[_Fault]:
        if names := self._unknown(value, floats=True):
            yield _Fault(names, choice=False)

    def _choices(self, condition: ir.Expr | None, kinds: set[_Kind]) -> Iterator[_Fault]:
        names = self._unknown(condition, floats=False) if condition is not None else frozenset[str]()
        if names and len(kinds) > 1:
            yield _Fault(names, choice=True)

    def _unknown(self, value: ir.Expr, floats: bool) -> frozenset[str]:
        """Return the hidden variables and the draws that a value follows from, or those that are floats."""
        found: set[str] = set()
        for node, _ in reached((value,), self.functions, self.lets):
            match node:
                case ir.StateRead(type, name) if not self.variables[name].visible:
                    found |= {name} if isinstance(type, Float) or not floats else set()
                case ir.LetRead(type, name) if name in self.lets and self.lets[name].draws:
                    found |= {name} if isinstance(type, Float) or not floats else set()
                case ir.Local(type, name) if name in self.locals:
                    found |= self.locals[name] if isinstance(type, Float) or not floats else set()
        return frozenset(found)


def _kinds(dist: ir.Dist) -> set[_Kind]:
    match dist:
        case ir.IfDist(then=then, otherwise=otherwise):
            return _kinds(then) | _kinds(otherwise)
        case ir.LetDist(body=body):
            return _kinds(body)
        case ir.UniformSet(otherwise=ir.Dist() as otherwise):
            return {"value"} | _kinds(otherwise)
        case ir.Clamped(low=low, high=high):
            return {(low, high)}
        case ir.Continuous():
            return {"density"}
    return {"value"}
