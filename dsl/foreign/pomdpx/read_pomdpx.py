"""Reads POMDPX (the format of the APPL toolkit): several variables, tables and decision diagrams."""

from __future__ import annotations

import math
import os.path
import re

from hypgen.dsl.foreign.pomdpx.tables import Axis, Tables
from hypgen.dsl.foreign.pomdpx.xml_tree import Element, parse
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
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.messages.source import Source

MAX_VALUES = 100_000
_PARTS = frozenset(
    {"Description", "Discount", "Horizon", "Variable", "InitialStateBelief"}
    | {"StateTransitionFunction", "ObsFunction", "RewardFunction"}
)
_KINDS = {"StateVar": "state", "ObsVar": "observation", "ActionVar": "action"}


def read(source: Source) -> ForeignModel:
    """Return the model of a POMDPX file; raises ``ModelError``."""
    return _Reader(source).run()


class _Reader:
    def __init__(self, source: Source) -> None:
        self.trouble = Trouble(source)
        self.variables: dict[str, list[Variable]] = {kind: [] for kind in _KINDS.values()}
        self.axes: dict[str, Axis] = {}  # by the name that tables use
        self.currents: dict[str, int] = {}  # state variables by their name after the step
        self.rewards: list[str] = []
        self.notes: list[str] = []
        self.tables = Tables(self.trouble)

    def run(self) -> ForeignModel:
        root = parse(self.trouble)
        if root.tag != "pomdpx":
            message = f"the document's element is '{root.tag}'"
            raise self.trouble.stop("E0911", message, root.start, len(root.tag) + 1, "it has to be <pomdpx>")
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
        self.trouble.raise_any()
        model = ForeignModel(
            "POMDPX", discount, tuple(self.variables["action"]), tuple(states), tuple(seen),
            starts, steps, sight, (),
        )  # fmt: skip
        rewards = tuple(without_observations(g, model, self.notes) for g in gains)
        return ForeignModel(
            model.format, discount, model.actions, model.states, model.observations,
            starts, steps, sight, rewards, tuple(self.notes),
        )  # fmt: skip

    def _part(self, parent: Element, tag: str) -> Element:
        found = parent.child(tag)
        if found is None:
            raise self._lacks(parent, f"<{tag}>")
        return found

    def _lacks(self, element: Element, what: str) -> Exception:
        message = f"<{element.tag}> lacks {what}"
        remedy, tag = f"add {what} to it", what.strip("<>")
        for child in element.children:
            if child.tag not in _PARTS and did_you_mean(child.tag, (tag,)):
                remedy = f"did you mean {what} where <{child.tag}> stands?"
        return self.trouble.stop("E0911", message, element.start, len(element.tag) + 1, remedy)

    def _discount(self, root: Element) -> float:
        element = self._part(root, "Discount")
        number = self.tables.number(element.text)
        if number is None or not 0 <= number <= 1:
            message = f"the discount is '{element.text[:30]}'"
            self.trouble.add("E0908", message, element.text_start, len(element.text), "give one from 0 to 1")
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
            if not name or name in self.axes:
                what = f"the name '{name}' is taken" if name else f"<{element.tag}> has no name"
                self.trouble.add(
                    "E0911", what, element.start, len(element.tag) + 1, "give it a name of its own"
                )
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
            what = "names a value twice" if names else "names no value"
            place = listed.text_start
            self.trouble.add(
                "E0911", f"<ValueEnum> {what}", place, len(listed.text.split("\n")[0]), "correct it"
            )
            return list(dict.fromkeys(names)) or ["none"]
        text = counted.text if counted is not None else ""
        if re.fullmatch(r"\d{1,9}", text) and 0 < int(text) <= MAX_VALUES:
            return [f"{kind[0]}{n}" for n in range(int(text))]
        message = f"<{element.tag}> says not how many values there are, or says '{text[:20]}'"
        remedy = f"give it <NumValues> from 1 to {MAX_VALUES}, or <ValueEnum>"
        self.trouble.add("E0911", message, element.start, len(element.tag) + 1, remedy)
        return ["none"]

    # Tables --------------------------------------------------------------------------------------

    def _axis(self, element: Element, name: str) -> Axis | None:
        if name in self.axes:
            return self.axes[name]
        remedy = did_you_mean(name, self.axes) or "declare it in <Variable>"
        message = f"there is no variable '{name[:30]}'"
        self.trouble.add("E0902", message, element.text_start, len(name), remedy)
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
            message = f"'{twice.name}' is a parent twice"
            self.trouble.add("E0911", message, parent.text_start, len(twice.name), "name it once")
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
                message = f"'{own.name}' has no law in <{part.tag}>"
                remedy = "name the variable as it is called there, before or after the step"
                self.trouble.add("E0911", message, var.text_start, len(own.name), remedy)
                continue
            law = self._law(element, own, parents, kind)
            if law is not None:
                found[own.read.number] = law
        missing = [a.name for a in self.axes.values() if a.read.kind == role and a.read.number not in found]
        if missing and not self.trouble.found:
            message = f"<{part.tag}> says nothing of '{missing[0]}'"
            self.trouble.add("E0911", message, part.start, len(part.tag) + 1, "add a <CondProb> of it")
        return tuple(found[n] for n in range(number_of) if n in found)

    def _law(self, element: Element, own: Axis, parents: list[Axis], kind: str) -> Law | None:
        wrong = [
            p for p in parents
            if p.read.kind == "observation" or (kind == "start" and p.read.kind != "state") or p is own
        ]  # fmt: skip
        if wrong:
            message = f"'{own.name}' cannot depend on '{wrong[0].name}' here"
            self.trouble.add("E0911", message, element.start, 9, "remove that parent")
            return None
        rows = self.tables.law(self._part(element, "Parameter"), parents, own)
        if rows is None:
            return None
        self._check_rows(element, own, parents, rows)
        unique: dict[Row, Row] = {}
        kept = [unique.setdefault(r, r) for r in (normalised(row.items()) for row in rows)]
        return Law(tuple(p.read for p in parents), kept)

    def _check_rows(
        self, element: Element, own: Axis, parents: list[Axis], rows: list[dict[int, float]]
    ) -> None:
        wrong = [n for n, row in enumerate(rows) if abs(math.fsum(row.values()) - 1) > TOLERANCE]
        for number in wrong[:3]:
            total, left, given = math.fsum(rows[number].values()), number, []
            for parent in reversed(parents):
                left, value = divmod(left, len(parent.names))
                given.append(f"{parent.name} = {parent.names[value]}")
            row = f"'{own.name}'" + (f" given {', '.join(reversed(given))}" if given else "")
            if total:
                message = f"the probabilities of {row} sum to {total:.6g}"
                self.trouble.add("E0904", message, element.start, 9, "make them sum to 1")
            else:
                message = f"there are no probabilities of {row}"
                self.trouble.add(
                    "E0905", message, element.start, 9, "give them, in an <Entry> of its own or with '*'"
                )
        if len(wrong) > 3:
            message = f"{len(wrong) - 3} more rows of '{own.name}' do not sum to 1"
            self.trouble.add("E0904", message, element.start, 9, "make them sum to 1")

    def _check_order(self, root: Element, laws: tuple[Law, ...], kind: str) -> None:
        if not self.trouble.found and len(drawing_order(laws, kind)) < len(laws):
            message = "state variables depend on each other in a circle"
            self.trouble.add("E0911", message, root.start, 7, "remove a parent")

    def _gains(self, part: Element) -> list[Gain]:
        gains = []
        for element in part.all("Func"):
            var = self._part(element, "Var")
            if var.text not in self.rewards:
                remedy = did_you_mean(var.text, self.rewards) or "declare it as <RewardVar>"
                message = f"there is no reward '{var.text[:30]}'"
                self.trouble.add("E0902", message, var.text_start, len(var.text), remedy)
            parents = self._parents(element)
            if parents is None:
                continue
            values = self.tables.values(self._part(element, "Parameter"), parents)
            if values is not None:
                gains.append(Gain(var.text, tuple(p.read for p in parents), values))
        return gains
