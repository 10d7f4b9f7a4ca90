# SPDX-License-Identifier: Apache-2.0
"""Findings of a sampled model: mistakes that no reading of its text can prove."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.interpret.value_text import action_text, value_text
from hypgen.dsl.ir.walk import Node, children
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.render import render, to_json
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.types import Type

_LINES = 12  # of a state that a person is shown
_WIDTH = 90  # characters of a value


@dataclass(frozen=True)
class Place:
    """The part of a model that is evaluated: its declaration, what it says, and for which binders."""

    span: Span | None
    nodes: tuple[Node, ...] = ()
    binders: tuple[ir.Binder, ...] = ()


@dataclass(frozen=True)
class Moment:
    """One sampled state, and the step from it as far as it had been computed."""

    state: Mapping[str, Any]
    after: Mapping[str, Any] | None = None
    action: int | None = None
    locals: Mapping[str, Any] = field(default_factory=dict)


@dataclass
class Finding:
    """A mistake and the first state that showed it; ``count`` says how often it was met."""

    diagnostic: Diagnostic
    count: int
    state: tuple[tuple[str, str], ...]

    @property
    def is_warning(self) -> bool:
        """Return whether the model has a meaning all the same."""
        return self.diagnostic.severity == "warning"

    def render(self, sources: Mapping[str, Source]) -> str:
        """Return the finding as text, its state last."""
        text = render(self.diagnostic, sources)
        if self.state:
            width = max(len(name) for name, _ in self.state)
            text += f"in this state, the first of {self.count:,}:\n" if self.count > 1 else "in this state:\n"
            text += "".join(f"  {name:{width}} = {_crop(value)}\n" for name, value in self.state[:_LINES])
            more = len(self.state) - _LINES
            text += f"  .. and {more} more\n" if more > 0 else ""
        return text

    def to_json(self) -> dict[str, Any]:
        """Return the finding as plain data."""
        return {**to_json(self.diagnostic), "count": self.count, "state": dict(self.state)}


def _text(value: Any, t: Type) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_text(entry, t) for entry in value)}]"
    return value_text(value, t)


def _crop(text: str) -> str:
    return text if len(text) <= _WIDTH else text[: _WIDTH - 3] + "..."


class Findings:
    """Collects findings: one for each code and place."""

    def __init__(self, model: ir.Model) -> None:
        self._model = model
        self._found: dict[tuple[str, Span | None], Finding] = {}

    def add(
        self,
        diagnostic: Diagnostic,
        count: int,
        moment: Callable[[], Moment],
        place: Place,
    ) -> None:
        """Count a finding; the first one of its kind and place is kept with its ``moment``.

        What the ``place`` reads is shown first.
        """
        key = (diagnostic.code, diagnostic.span)
        if key in self._found:
            self._found[key].count += count
        else:
            state = tuple(_describe(self._model, moment(), place))
            self._found[key] = Finding(diagnostic, count, state)

    def add_whole(self, diagnostic: Diagnostic) -> None:
        """Add a finding about all that was sampled, which no one state shows."""
        self._found[diagnostic.code, diagnostic.span] = Finding(diagnostic, 1, ())

    def all(self) -> list[Finding]:
        """Return the findings in the order of their places."""
        nowhere = Span("", 0, 0, 0, 0)
        return sorted(self._found.values(), key=lambda f: (f.diagnostic.span or nowhere, f.diagnostic.code))


def _describe(model: ir.Model, moment: Moment, place: Place) -> Iterator[tuple[str, str]]:
    """Yield names and values: locals, what ``place`` reads, then the rest of the state."""
    types = {b.name: b.type for b in place.binders}
    types |= {b.name: b.type for node in place.nodes for b in _bound(node)}
    for name, value in moment.locals.items():
        if name in types:
            yield name, _text(value, types[name])
    wanted = list(dict.fromkeys(_reads(model, place.nodes)))
    wanted += [(v.name, False) for v in model.variables if (v.name, False) not in wanted]
    variables = {v.name: v for v in model.variables}
    if moment.action is not None:
        yield model.action.name, action_text(moment.action, model.action)
    for name, primed in wanted:
        values = moment.after if primed and not variables[name].fixed else moment.state
        if values is not None and name in values:
            yield name + "'" * primed, _text(values[name], variables[name].type)


def _bound(node: Node) -> Iterator[ir.Binder]:
    yield from getattr(node, "binders", ())
    for child in children(node):
        yield from _bound(child)


def _reads(model: ir.Model, nodes: tuple[Node, ...]) -> Iterator[tuple[str, bool]]:
    """Yield the variables that are read, primed or not, in order, through functions and lets."""
    functions = {f.name: f.body for f in model.functions}
    lets = {x.name: x.dist for x in model.all_lets}
    seen: set[tuple[str, bool]] = set()

    def visit(node: Node, primed: bool) -> Iterator[tuple[str, bool]]:
        if isinstance(node, ir.StateRead):
            yield node.variable, primed or node.primed
        for child in children(node):
            yield from visit(child, primed)
        target: Node | None = None
        if isinstance(node, ir.Call):
            name, target, inner = f"fn {node.function}", functions[node.function], primed or node.primed
        elif isinstance(node, ir.LetRead):
            name, target, inner = f"let {node.let}", lets[node.let], primed or node.primed
        if target is not None and (name, inner) not in seen:
            seen.add((name, inner))
            yield from visit(target, inner)

    for node in nodes:
        yield from visit(node, False)
