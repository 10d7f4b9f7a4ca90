# SPDX-License-Identifier: Apache-2.0
"""Writes a foreign model as text of this language, laid out as ``hypgen fmt`` does."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hypgen.dsl.foreign.tables.foreign_model import ForeignModel, Gain, Law, Read, Row, Variable
from hypgen.dsl.foreign.tables.names import Names, is_plain, type_name
from hypgen.dsl.foreign.tables.numbers import in_full, shown
from hypgen.dsl.foreign.tables.reduction import reduced_gain, reduced_law
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.foreign.writer import cases, shared_tables
from hypgen.dsl.foreign.writer.blind_policy import Blind, best_blind
from hypgen.dsl.foreign.writer.branches import Branches
from hypgen.dsl.foreign.writer.cases import Scrutinee, Values
from hypgen.dsl.foreign.writer.shared_tables import Draws, Index, Numbers, Parts, Successors
from hypgen.dsl.foreign.writer.shortest_path import Paths

EDITOR_LINE = "-*- hypgen -*-"  # tells an editor that this is no file in Cassandra's format
_MOST_NAMES = 10_000  # a name is a word for the parser, and those are limited


def write(model: ForeignModel, name: str, origin: str, horizon: int | None, paths: Paths | None) -> str:
    """Return the text of ``model``: called ``name``, from a file called ``origin``.

    ``paths`` has what a model needs that has neither a horizon nor a discount below 1.
    """
    return _Writer(model, name, origin, horizon, paths).text()


@dataclass(frozen=True)
class _Own:
    """How a variable goes by in the text: its element (or none), its name and its type."""

    element: str
    name: str
    values: Values

    @property
    def path(self) -> str:
        return f"{self.element}.{self.name}" if self.element else self.name


class _Writer:
    def __init__(
        self, model: ForeignModel, name: str, origin: str, horizon: int | None, paths: Paths | None
    ) -> None:
        self.model, self.origin, self.paths = model, origin, paths
        self.name = name
        # A discount of 0 counts the first step alone.
        self.discount, self.horizon = (model.discount or 1.0), horizon if model.discount else 1
        self.names = Names(["v", "k", "r", "system", "State", "Action", "Observation", "act", "state"])
        self.types: list[str] = []
        self.tables: list[str] = []
        self.actions = self._actions()
        self.states = self._states()
        self.observations = self._observations()

    def text(self) -> str:
        """Return the whole text."""
        elements = [self._element(number) for number in range(len(self.states))]
        sensors = [line for number in range(len(self.observations)) for line in self._sensor(number)]
        rewards = [line for gain in self.model.rewards for line in self._reward(gain)]
        parts = [
            [*self._header(), f"model {self.name}"],
            self.types,
            [*self._settings(), f"action {self._act}: {self.action_type}"],
            self.tables,
            *elements,
            sensors,
            rewards,
            [*self._end(), *(self._policy() if self.paths is None else self._bounded(self.paths))],
        ]
        return "\n\n".join("\n".join(part) for part in parts if part) + "\n"

    # Declarations --------------------------------------------------------------------------------

    def _header(self) -> list[str]:
        origin = re.sub(r"[^\x20-\x7e]", "?", self.origin)
        text = [EDITOR_LINE, f"Imported by hypgen from {self.model.format}: {origin}", *self.model.notes]
        if not self.model.discount:
            text.append("A discount of 0 counts the first step alone: that is a horizon of 1.")
        return [f"# {line}" for line in text]

    def _settings(self) -> list[str]:
        # The language keeps a discount as it is written, not as a float32.
        lines = [f"discount {repr(self.discount).removesuffix('.0')}"]
        return [*lines, f"horizon {self.horizon}"] if self.horizon is not None else lines

    def _type(self, wanted: str, variable: Variable) -> Values:
        """Declare the type of a variable."""
        name = wanted if wanted in ("State", "Action", "Observation") else self.names.unique(wanted, "Type")
        if variable.names is not None and variable.size > _MOST_NAMES:
            self.types.append(f"# The {variable.size} names of the file are left out: {name} counts them.")
        if variable.names is None or variable.size > _MOST_NAMES:
            self.types.append(f"type {name} = 0 .. {variable.size - 1}")
            return Values(name, [str(n) for n in range(variable.size)])
        own = Names(self.names.taken)
        variants = [own.unique(n, variable.name[:1].lower() or "v") for n in variable.names]
        changed = [(v, n) for v, n in zip(variants, variable.names, strict=True) if not is_plain(n, v)]
        self.types += [f"# {v} is '{re.sub(r'[^ -~]', '?', n)}' in the file" for v, n in changed[:20]]
        whole = f"enum {name} {{ {', '.join(variants)} }}"
        if len(whole) <= cases.WIDTH:
            self.types.append(whole)
        else:
            self.types += [f"enum {name} {{", *_wrapped(variants), "}"]
        return Values(name, variants)

    def _actions(self) -> list[_Own]:
        self._act, self.action_type = "act", "Action"
        actions = self.model.actions
        if len(actions) == 1:
            return [_Own("", "act", self._type("Action", actions[0]))]
        own = []
        for variable in actions:
            values = self._type(type_name(variable.name), variable)
            own.append(_Own("act", self.names.unique(variable.name, "act"), values))
        fields = "  ".join(f"{o.name}: {o.values.type_name}" for o in own)
        self.types.append(f"record Action {{ {fields} }}")
        return own

    def _states(self) -> list[_Own]:
        states = self.model.states
        if len(states) == 1:
            return [_Own("system", "state", self._type("State", states[0]))]
        return [
            _Own(self.names.unique(v.name, "element"), "state", self._type(type_name(v.name), v))
            for v in states
        ]

    def _observations(self) -> list[_Own]:
        seen = self.model.observations
        if len(seen) == 1:
            return [_Own("", self.names.unique("seen", "seen"), self._type("Observation", seen[0]))]
        return [
            _Own("", self.names.unique(v.name, "seen"), self._type(type_name(v.name) + "Value", v))
            for v in seen
        ]

    # Laws ----------------------------------------------------------------------------------------

    def _own(self, read: Read) -> _Own:
        groups = {"action": self.actions, "observation": self.observations}
        return groups.get(read.kind, self.states)[read.number]

    def _scrutinee(self, read: Read, inside: int | None) -> Scrutinee:
        """Return how ``read`` is written in the element of state ``inside``, or elsewhere."""
        own = self._own(read)
        if read.kind == "action":
            return Scrutinee(own.path, own.values)
        path = own.name if inside == read.number else own.path
        return Scrutinee(path + ("'" if read.kind == "next" else ""), own.values)

    def _law(self, law: Law, own: _Own, stem: str, inside: int | None) -> tuple[str, list[str]]:
        """Return `=` or `~` and the lines of what follows it; large tables are declared."""
        law = reduced_law(law)
        reads = [self._scrutinee(r, inside) for r in law.reads]

        def is_own(read: Scrutinee, rows: Sequence[Row]) -> bool:
            return read.values is own.values and all(
                len(row) == 1 and row[0][0] == number for number, row in enumerate(rows)
            )

        def small(reads: Sequence[Scrutinee], rows: Table[Row], indent: int) -> list[str] | None:
            return cases.match_text(reads, rows, lambda r: cases.row_text(r, own.values), is_own, indent)

        distinct = law.rows.distinct()
        sign = "~" if any(len(row) > 1 for row in distinct) else "="
        indent = 2 if inside is not None else 0
        lines = small(reads, law.rows, indent)
        if lines is not None:
            return sign, lines
        target, values = Index(own.path, own.values.type_name), own.values.names
        if not reads:
            declared, text = shared_tables.weights(stem, target, distinct[0], len(values), self.names)
            self._table(f"The law of {stem.replace('_', ' ')}, by value.", declared)
            return sign, [text]
        parts: Parts[Row] = (
            Successors(target, values, self.names)
            if sign == "="
            else Draws(stem, target, values, distinct, self.names)
        )
        lines = Branches(reads, law.rows, small, parts).lines(stem, indent)
        by = ", ".join(self._scrutinee(r, None).text for r in law.reads)
        self._table(f"The law of {stem.replace('_', ' ')}, by {by}.", parts.declarations())
        return sign, lines

    def _table(self, about: str, lines: list[str]) -> None:
        self.tables += [*([""] if self.tables else []), f"# {about}", *lines]

    def _element(self, number: int) -> list[str]:
        own, model = self.states[number], self.model
        stem = own.name if len(self.states) == 1 else own.element
        kind = "visible" if model.states[number].visible else "hidden"
        start = self._law(model.starts[number], own, f"{stem}_start", number)
        step = self._law(model.transitions[number], own, stem, number)
        return [
            f"element {own.element} {{",
            f"  {kind} {own.name}: {own.values.type_name}",
            *_defined(f"  init {own.name}", *start),
            *_defined(f"  {own.name}'", *step),
            "}",
        ]

    def _sensor(self, number: int) -> list[str]:
        own = self.observations[number]
        sign, lines = self._law(self.model.sensors[number], own, own.name, None)
        return _defined(f"observe {own.name}: {own.values.type_name}", sign, lines)

    def _reward(self, gain: Gain) -> list[str]:
        gain = reduced_gain(gain)
        reads = [self._scrutinee(r, None) for r in gain.reads]
        name = self.names.unique(gain.name, "gain")

        def small(reads: Sequence[Scrutinee], values: Table[float], indent: int) -> list[str] | None:
            return cases.match_text(reads, values, in_full, lambda read, entries: False, indent)

        lines = small(reads, gain.values, 0)
        if lines is None:
            parts = Numbers(self.names)
            lines = Branches(reads, gain.values, small, parts).lines(name, 0)
            if declared := parts.declarations():
                self._table(f"The reward, by {', '.join(r.text for r in reads)}.", declared)
        return _defined(f"reward {name}", "=", lines)

    # End and policy ------------------------------------------------------------------------------

    def _end(self) -> list[str]:
        """Return what ends an episode: a state that is never left and earns nothing from then on."""
        if len(self.states) > 1:
            return []
        absorbing = [n for n in range(self.model.states[0].size) if _is_absorbing(self.model, n)]
        if not absorbing or len(absorbing) > 8 or len(absorbing) == self.model.states[0].size:
            return []
        names = self.states[0].values.names
        text = " or ".join(f"system.state' == {names[n]}" for n in absorbing)
        return ["# Nothing is earned from here on, whatever is done.", f"terminal when {text}"]

    def _bounded(self, paths: Paths) -> list[str]:
        """Return the default policy and the bounds where nothing but the model ends an episode."""
        lines = ["# No state is worth more, and none less under the default policy."]
        lines += [
            f"bound {name} = {shown(value)}" for name, value in (("upper", paths.upper), ("tail", paths.tail))
        ]
        if paths.action is None:
            return [
                *lines,
                "# No policy that always does the same ends everywhere: the default one is uniform.",
            ]
        return [*lines, *self._chosen(Blind(paths.action, paths.value))]

    def _policy(self) -> list[str]:
        blind = best_blind(self.model, self.horizon)
        if blind is None:
            return ["# The model is too large to choose a default policy for it: it is uniform."]
        return self._chosen(blind)

    def _chosen(self, blind: Blind) -> list[str]:
        chosen = [own.values.names[v] for own, v in zip(self.actions, blind.action, strict=True)]
        text = chosen[0] if len(chosen) == 1 else f"Action({', '.join(chosen)})"
        comment = f"# Of the policies that always do the same, the best from the start: {blind.value:.4g}."
        return [comment, f"policy default = {text}"]


def _defined(head: str, sign: str, lines: list[str]) -> list[str]:
    return [f"{head} {sign} {lines[0]}", *lines[1:]]


def _wrapped(words: Sequence[str]) -> list[str]:
    lines, line = [], ""
    for number, word in enumerate(words):
        word += "," if number < len(words) - 1 else ""
        if line and len(line) + len(word) > cases.WIDTH - 4:
            lines.append(f"  {line}")
            line = ""
        line = f"{line} {word}" if line else word
    return [*lines, f"  {line}"]


def _is_absorbing(model: ForeignModel, state: int) -> bool:
    step = model.transitions[0]
    actions = range(model.actions[0].size)
    if step.reads != (Read("action"), Read("state")):
        return False
    if any([v for v, _ in step.rows.at((a, state))] != [state] for a in actions):
        return False
    for gain in model.rewards:
        if len(gain.reads) != 2 or gain.reads[0] != Read("action") or gain.reads[1].number:
            return False
        if any(gain.values.at((a, state)) for a in actions):
            return False
    return True
