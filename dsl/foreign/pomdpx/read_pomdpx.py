# SPDX-License-Identifier: Apache-2.0
"""Reads POMDPX (the format of the APPL toolkit): several variables, tables and decision diagrams."""

from __future__ import annotations

import math
import os.path
import re

from hypgen.dsl.foreign.pomdpx.tables import Axis, Tables
from hypgen.dsl.foreign.pomdpx.xml_tree import Element, parse, place_of
from hypgen.dsl.foreign.tables.foreign_model import (
    ForeignModel,
    Gain,
    Law,
    Read,
    Row,
    Variable,
    drawing_order,
)
from hypgen.dsl.foreign.tables.reduction import without_observations
from hypgen.dsl.foreign.tables.rows import TOLERANCE, normalised
from hypgen.dsl.foreign.tables.sums import Sums
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_pomdpx
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.messages.source import Source, Span

MAX_VALUES = 100_000
_PARTS = frozenset(
    {"Description", "Discount", "Horizon", "Variable", "InitialStateBelief"}
    | {"StateTransitionFunction", "ObsFunction", "RewardFunction"}
)
_KINDS = {"StateVar": "state", "ObsVar": "observation", "ActionVar": "action"}


def read(source: Source, tolerance: float) -> ForeignModel:
    """Return the model of a POMDPX file, rows off by ``tolerance`` scaled to 1; raises ``ModelError``."""
    return _Reader(source, tolerance).run()


class _Reader:
    def __init__(self, source: Source, tolerance: float) -> None:
        self.trouble = Trouble(source)
        self.sums = Sums(self.trouble, tolerance)
        self.discount_place: Span | None = None
        self.variables: dict[str, list[Variable]] = {kind: [] for kind in _KINDS.values()}
        self.axes: dict[str, Axis] = {}  # by the name that tables use
        self.currents: dict[str, int] = {}  # state variables by their name after the step
        self.rewards: list[str] = []
        self.notes: list[str] = []
        self.tables = Tables(self.trouble, self.sums)

    def run(self) -> ForeignModel:
        root = parse(self.trouble)
        if root.tag != "pomdpx":
            raise self.trouble.stop(e09_pomdpx.other_root(root.tag, place_of(root, self.trouble)))
        discount = self._discount(root)
        self._declare(self._part(root, "Variable"))
        for kind, word in (("state", "StateVar"), ("action", "ActionVar")):
            if not self.variables[kind]:
                raise self._lacks(root, f"a <{word}>")
        states, seen = self.variables["state"], self.variables["observation"]
        starts = self._laws(self._part(root, "InitialStateBelief"), "start")
        steps = self._laws(self._part(root, "StateTransitionFunction"), "next")
        sight = self._laws(self._part(root, "ObsFunction"), "observation") if seen else ()
        gains = self._gains(self._part(root, "RewardFunction"))
        self._check_order(root, starts, "state")
        self._check_order(root, steps, "next")
        self.sums.tell()
        self.trouble.raise_any()
        model = ForeignModel(
            "POMDPX", discount, tuple(self.variables["action"]), tuple(states), tuple(seen),
            starts, steps, sight, (),
        )  # fmt: skip
        rewards = tuple(without_observations(g, model, self.notes) for g in gains)
        return ForeignModel(
            model.format, discount, model.actions, model.states, model.observations,
            starts, steps, sight, rewards, tuple(self.notes + self.sums.notes()), self.discount_place,
        )  # fmt: skip

    def _part(self, parent: Element, tag: str) -> Element:
        found = parent.child(tag)
        if found is None:
            raise self._lacks(parent, f"<{tag}>")
        return found

    def _lacks(self, element: Element, what: str) -> Exception:
        tag, others = what.strip("<>"), [c.tag for c in element.children if c.tag not in _PARTS]
        alike = [other for other in others if did_you_mean(other, (tag,))]
        instead, span = alike[-1] if alike else None, place_of(element, self.trouble)
        return self.trouble.stop(e09_pomdpx.lacks_part(element.tag, what, instead, span))

    def _discount(self, root: Element) -> float:
        element = self._part(root, "Discount")
        number = self.tables.number(element.text)
        span = self.discount_place = self.trouble.span(element.text_start, len(element.text))
        if number is None or not 0 <= number <= 1:
            self.trouble.add(e09_pomdpx.wrong_discount(element.text, span))
            return 0.5
        return number

    # Variables -----------------------------------------------------------------------------------

    def _declare(self, part: Element) -> None:
        for element in part.children:
            if element.tag == "RewardVar":
                self.rewards.append(element.attributes.get("vname", ""))
            elif element.tag in _KINDS:
                self._variable(element, _KINDS[element.tag])

    def _variable(self, element: Element, kind: str) -> None:
        names = self._names(element, kind)
        given = element.attributes
        called = [given.get(a, "") for a in (("vnamePrev", "vnameCurr") if kind == "state" else ("vname",))]
        for name in called:
            if not name:
                self.trouble.add(e09_pomdpx.nameless(element.tag, place_of(element, self.trouble)))
            elif name in self.axes:
                self.trouble.add(e09_pomdpx.duplicate_name(name, place_of(element, self.trouble)))
        number = len(self.variables[kind])
        stem = os.path.commonprefix(called).rstrip("_") if kind == "state" else called[0]
        visible = given.get("fullyObs", "false").strip().lower() in ("true", "1")
        size = len(names)
        plain = [f"{kind[0]}{n}" for n in range(size)] == names and element.child("NumValues") is not None
        variable = Variable(stem or called[0], size, None if plain else tuple(names), visible)
        self.variables[kind].append(variable)
        for name, role in zip(called, ("state", "next") if kind == "state" else (kind,), strict=True):
            self.axes[name] = Axis(name, names, Read(role, number))

    def _names(self, element: Element, kind: str) -> list[str]:
        listed, counted = element.child("ValueEnum"), element.child("NumValues")
        if listed is not None:
            names = listed.text.split()
            if names and len(names) == len(set(names)):
                return names
            span = self.trouble.span(listed.text_start, len(listed.text.split("\n")[0]))
            self.trouble.add(e09_pomdpx.duplicate_value(span) if names else e09_pomdpx.no_value(span))
            return list(dict.fromkeys(names)) or ["none"]
        text = counted.text if counted is not None else ""
        if re.fullmatch(r"\d{1,9}", text) and 0 < int(text) <= MAX_VALUES:
            return [f"{kind[0]}{n}" for n in range(int(text))]
        span = place_of(element, self.trouble)
        self.trouble.add(e09_pomdpx.no_size(element.tag, text, MAX_VALUES, span))
        return ["none"]

    # Tables --------------------------------------------------------------------------------------

    def _axis(self, element: Element, name: str) -> Axis | None:
        if name in self.axes:
            return self.axes[name]
        span = self.trouble.span(element.text_start, len(name))
        self.trouble.add(e09_pomdpx.unknown_variable(name, self.axes, span))
        return None

    def _parents(self, element: Element) -> list[Axis] | None:
        parent = element.child("Parent")
        names = parent.text.split() if parent is not None else []
        if names in ([], ["null"]):
            return []
        assert parent is not None
        found = [self._axis(parent, n) for n in names]
        known = [a for a in found if a is not None]
        twice = next((a for n, a in enumerate(known) if a in known[:n]), None)
        if twice is not None:
            span = self.trouble.span(parent.text_start, len(twice.name))
            self.trouble.add(e09_pomdpx.duplicate_parent(twice.name, span))
        return None if len(known) < len(names) or twice is not None else known

    def _laws(self, part: Element, kind: str) -> tuple[Law, ...]:
        """Return the laws of all state variables (at the start, or after a step) or of all observations."""
        role = "state" if kind == "start" else kind
        number_of = len(self.variables["observation" if kind == "observation" else "state"])
        found: dict[int, Law] = {}
        for element in part.all("CondProb"):
            var = self._part(element, "Var")
            own, parents = self._axis(var, var.text), self._parents(element)
            if own is None or parents is None:
                continue
            if own.read.kind != role:
                span = self.trouble.span(var.text_start, len(own.name))
                self.trouble.add(e09_pomdpx.misplaced_law(own.name, part.tag, span))
                continue
            law = self._law(element, own, parents, kind)
            if law is not None:
                found[own.read.number] = law
        missing = [a.name for a in self.axes.values() if a.read.kind == role and a.read.number not in found]
        if missing and not self.trouble.found:
            self.trouble.add(e09_pomdpx.law_missing(missing[0], part.tag, place_of(part, self.trouble)))
        return tuple(found[n] for n in range(number_of) if n in found)

    def _law(self, element: Element, own: Axis, parents: list[Axis], kind: str) -> Law | None:
        wrong = [
            p for p in parents
            if p.read.kind == "observation" or (kind == "start" and p.read.kind != "state") or p is own
        ]  # fmt: skip
        if wrong:
            span = self.trouble.span(element.start, 9)
            self.trouble.add(e09_pomdpx.wrong_parent(own.name, wrong[0].name, span))
            return None
        rows = self.tables.law(self._part(element, "Parameter"), parents, own)
        if rows is None:
            return None
        self._check_rows(element, own, parents, rows)
        return Law(tuple(p.read for p in parents), rows.mapped(normalised))

    def _check_rows(self, element: Element, own: Axis, parents: list[Axis], rows: Table[Row]) -> None:
        wrong = rows.found(lambda row: abs(_total(row) - 1) > TOLERANCE)
        span, missing, first = self.trouble.span(element.start, 9), 0, ""
        for row, (values, number) in wrong.items():
            given = [f"{p.name} = {p.names[value]}" for p, value in zip(parents, values, strict=True)]
            words = f"'{own.name}'" + (f" given {', '.join(given)}" if given else "")
            if row:
                self.sums.check(words, _total(row), span, number)
            else:
                missing, first = number, words
        if missing:
            self.trouble.add(e09_pomdpx.rows_missing(first, missing, span))

    def _check_order(self, root: Element, laws: tuple[Law, ...], kind: str) -> None:
        if not self.trouble.found and len(drawing_order(laws, kind)) < len(laws):
            self.trouble.add(e09_pomdpx.circular_laws(self.trouble.span(root.start, 7)))

    def _gains(self, part: Element) -> list[Gain]:
        gains = []
        for element in part.all("Func"):
            var = self._part(element, "Var")
            if var.text not in self.rewards:
                span = self.trouble.span(var.text_start, len(var.text))
                self.trouble.add(e09_pomdpx.unknown_reward(var.text, self.rewards, span))
            parents = self._parents(element)
            if parents is None:
                continue
            values = self.tables.values(self._part(element, "Parameter"), parents)
            if values is not None:
                gains.append(Gain(var.text, tuple(p.read for p in parents), values))
        return gains


def _total(row: Row) -> float:
    return math.fsum(p for _, p in row)
