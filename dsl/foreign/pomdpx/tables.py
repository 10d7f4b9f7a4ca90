# SPDX-License-Identifier: Apache-2.0
"""The parameters of POMDPX: tables of entries, and decision diagrams."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

from hypgen.dsl.foreign.pomdpx.diagram import Diagram, TooLargeError
from hypgen.dsl.foreign.pomdpx.xml_tree import Element, place_of
from hypgen.dsl.foreign.tables.foreign_model import Read, Row
from hypgen.dsl.foreign.tables.plan import Plan
from hypgen.dsl.foreign.tables.sums import Sums
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_pomdpx

MAX_ROWS = 2_000_000  # of a table as the text has it
MAX_PARTS = 6_000_000  # of the nodes of a table's diagram
MAX_WRITTEN = 10_000_000  # parts of a table's diagram, those that are written again included
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_MOST_NESTED = 100
_ALL = ("*", "-")
Entry = TypeVar("Entry", bound=Hashable)


@dataclass(frozen=True)
class Axis:
    """A variable as tables name it."""

    name: str
    names: list[str]
    read: Read

    @property
    def size(self) -> int:
        """Return how many values it has."""
        return len(self.names)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Return the values by name."""
        return {name: number for number, name in enumerate(self.names)}


@dataclass
class _Target:
    """A table in the making: its axes, of a law the child's the last, and where numbers go."""

    axes: list[Axis]
    diagram: Diagram
    is_law: bool
    templates: dict[str, Element] = field(default_factory=dict)


class Tables:
    """Fills tables from <Parameter> elements."""

    def __init__(self, trouble: Trouble, sums: Sums) -> None:
        self.trouble, self.sums = trouble, sums

    def number(self, text: str) -> float | None:
        """Return the number that ``text`` is, None if it is none."""
        if not _NUMBER.fullmatch(text):
            return None
        return value if math.isfinite(value := float(text)) else None

    def law(self, element: Element, parents: list[Axis], own: Axis) -> Table[Row] | None:
        """Return the rows of a law, with zeros as they are given; None after a mistake."""
        target = _Target([*parents, own], self._diagram([*parents, own]), True)
        if not self._fill(element, target, "ProbTable"):
            return None
        return self._table(element, target, lambda node: _row(node, own.size))

    def values(self, element: Element, parents: list[Axis]) -> Table[float] | None:
        """Return the values of a function; None after a mistake."""
        target = _Target(parents, self._diagram(parents), False)
        if not self._fill(element, target, "ValueTable"):
            return None
        return self._table(element, target, lambda number: number or 0.0)

    def _diagram(self, axes: list[Axis]) -> Diagram:
        return Diagram([a.size for a in axes], MAX_WRITTEN)

    def _table(self, element: Element, target: _Target, entry: Callable[[Any], Entry]) -> Table[Entry]:
        parents = target.axes[: len(target.axes) - target.is_law]
        try:
            table = target.diagram.table(entry, len(parents), MAX_PARTS)
            if Plan(table).entries <= MAX_ROWS:
                return table
        except TooLargeError:
            pass
        span = self.trouble.span(element.start, 10)
        raise self.trouble.stop(e09_pomdpx.many_rows([a.size for a in parents], MAX_ROWS, span))

    def _fill(self, element: Element, target: _Target, tag: str) -> bool:
        before = len(self.trouble.found)
        kind = element.attributes.get("type", "TBL").strip().upper()
        if kind == "TBL":
            for entry in element.all("Entry"):
                self._entry(entry, target, tag)
        elif kind == "DD":
            target.templates = {t.attributes.get("id", ""): t for t in element.all("SubDAGTemplate")}
            dag = element.child("DAG")
            if dag is None:
                self.trouble.add(e09_pomdpx.no_diagram(place_of(element, self.trouble)))
            else:
                self._inside(dag, target, {}, 0)
        else:
            self.trouble.add(e09_pomdpx.unknown_parameter(kind, place_of(element, self.trouble)))
        return len(self.trouble.found) == before

    def _write(
        self,
        target: _Target,
        box: Sequence[int | None],
        element: Element,
        number: Callable[[int], float],
        strides: Sequence[int] = (),
        diagonal: bool = False,
    ) -> None:
        """Write the numbers of a box of combinations; there may not be too many in all."""
        try:
            target.diagram.write(box, strides or [0] * len(box), number, diagonal)
        except TooLargeError:
            raise self.trouble.stop(e09_pomdpx.many_rewrites(place_of(element, self.trouble))) from None

    # Tables of entries ---------------------------------------------------------------------------

    def _entry(self, entry: Element, target: _Target, tag: str) -> None:
        instance, numbers = entry.child("Instance"), entry.child(tag)
        if instance is None or numbers is None:
            lacks = tag if instance is not None else "Instance"
            self.trouble.add(e09_pomdpx.incomplete_entry(tag, lacks, place_of(entry, self.trouble)))
            return
        words = instance.text.split()
        if len(words) != len(target.axes):
            span = self.trouble.span(instance.text_start, len(instance.text))
            self.trouble.add(e09_pomdpx.wrong_instance(len(words), [a.name for a in target.axes], span))
            return
        box: list[int | None] = []
        for word, axis in zip(words, target.axes, strict=True):
            if word not in _ALL and not self._is_value(word, axis, instance):
                return
            box.append(None if word in _ALL else axis.numbers[word])
        listed = [n for n, word in enumerate(words) if word == "-"]
        strides, size = [0] * len(box), 1
        for n in reversed(listed):
            strides[n] = size
            size *= target.axes[n].size
        if numbers.text == "identity" and target.is_law and self._is_identity(target, listed):
            strides[listed[0]], strides[-1] = 1, 0
            self._write(target, box, entry, lambda _: 1.0, strides, diagonal=True)
            return
        values = self._numbers(numbers, target, size)
        if values is not None:
            self._write(target, box, entry, values.__getitem__, strides)

    def _is_identity(self, target: _Target, listed: list[int]) -> bool:
        """Return whether an entry lists a parent, and a child with as many values."""
        last = len(target.axes) - 1
        return (
            len(listed) == 2 and listed[1] == last and target.axes[listed[0]].size == target.axes[last].size
        )

    def _is_value(self, word: str, axis: Axis, place: Element) -> bool:
        if word in axis.numbers:
            return True
        span = self.trouble.span(place.text_start, len(place.text.split("\n")[0]))
        self.trouble.add(e09_pomdpx.unknown_value(axis.name, word, axis.names, span))
        return False

    def _numbers(self, element: Element, target: _Target, size: int) -> Sequence[float] | None:
        """Return the numbers of an entry, one for each combination of the values marked ``-``."""
        text = element.text
        if text == "identity":
            self.trouble.add(e09_pomdpx.misplaced_identity(place_of(element, self.trouble)))
            return None
        if size > MAX_WRITTEN:
            self.trouble.add(e09_pomdpx.large_entry(MAX_WRITTEN, place_of(element, self.trouble)))
            return None
        if text == "uniform":
            return [1.0 / target.axes[-1].size] * size
        words = text.split()
        if len(words) != size:
            span = place_of(element, self.trouble)
            self.trouble.add(e09_pomdpx.wrong_count(element.tag, len(words), size, span))
            return None
        values = [self.number(w) for w in words]
        for word, value in zip(words, values, strict=True):
            if value is None or (target.is_law and not self.sums.is_probability(value)):
                self._no_number(word, element, target)
                return None
        return [v for v in values if v is not None]

    def _no_number(self, word: str, element: Element, target: _Target) -> None:
        wrong = e09_pomdpx.no_number if not target.is_law else e09_pomdpx.no_probability
        # Comments between the words are not in the element's text; the word stands behind its start still.
        found = re.compile(rf"(?<![^\s>]){re.escape(word)}(?![^\s<])").search(
            self.trouble.source.text, element.text_start
        )
        start = found.start() if found else element.text_start
        self.trouble.add(wrong(word, self.trouble.span(start, len(word))))

    # Decision diagrams ---------------------------------------------------------------------------

    def _inside(self, parent: Element, target: _Target, given: dict[str, int], depth: int) -> None:
        """Fill in what is below ``parent``, where ``given`` holds."""
        if depth > _MOST_NESTED:
            raise self.trouble.stop(e09_pomdpx.deep_diagram(self.trouble.span(parent.start, 4)))
        for element in parent.children:
            if element.tag == "Node":
                self._node(element, target, given, depth)
            elif element.tag == "Terminal":
                self._terminal(element, target, given)
            elif element.tag == "SubDAG":
                self._sub_dag(element, target, given, depth)
            else:
                self.trouble.add(e09_pomdpx.misplaced_element(element.tag, place_of(element, self.trouble)))

    def _axis(self, element: Element, target: _Target) -> Axis | None:
        name = element.attributes.get("var", "")
        for axis in target.axes:
            if axis.name == name:
                return axis
        known = [a.name for a in target.axes]
        self.trouble.add(e09_pomdpx.not_of_table(name, known, place_of(element, self.trouble)))
        return None

    def _node(self, node: Element, target: _Target, given: dict[str, int], depth: int) -> None:
        axis = self._axis(node, target)
        if axis is None:
            return
        for edge in node.all("Edge"):
            word = edge.attributes.get("val", "")
            if word == "*":
                self._inside(edge, target, given, depth + 1)
            elif word != "-" and self._is_value(word, axis, edge):
                value = axis.numbers[word]
                if given.get(axis.name, value) == value:
                    self._inside(edge, target, {**given, axis.name: value}, depth + 1)

    def _box(self, target: _Target, given: dict[str, int]) -> list[int | None]:
        return [given.get(a.name) for a in target.axes]

    def _terminal(self, element: Element, target: _Target, given: dict[str, int]) -> None:
        value = self.number(element.text)
        if value is None or (target.is_law and not self.sums.is_probability(value)):
            self._no_number(element.text, element, target)
            return
        number = value
        self._write(target, self._box(target, given), element, lambda _: number)

    def _sub_dag(self, element: Element, target: _Target, given: dict[str, int], depth: int) -> None:
        kind = element.attributes.get("type", "")
        if kind == "template":
            template = target.templates.get(element.attributes.get("idref", ""))
            if template is None:
                self.trouble.add(e09_pomdpx.unknown_template(place_of(element, self.trouble)))
            else:
                self._inside(template, target, given, depth + 1)
        elif kind not in ("deterministic", "persistent", "uniform") or not target.is_law:
            self.trouble.add(e09_pomdpx.misplaced_sub_diagram(kind, place_of(element, self.trouble)))
        elif kind == "uniform":
            share = 1.0 / target.axes[-1].size
            self._write(target, self._box(target, given), element, lambda _: share)
        elif kind == "deterministic":
            self._deterministic(element, target, given)
        else:
            self._persistent(element, target, given)

    def _deterministic(self, element: Element, target: _Target, given: dict[str, int]) -> None:
        own, word = target.axes[-1], element.attributes.get("val", "")
        if self._is_value(word, own, element):
            box = self._box(target, {**given, own.name: own.numbers[word]})
            self._write(target, box, element, lambda _: 1.0)

    def _persistent(self, element: Element, target: _Target, given: dict[str, int]) -> None:
        """The variable keeps its value: the parent that is it before the step says which."""
        own = target.axes[-1]
        before = [
            n
            for n, a in enumerate(target.axes)
            if a.read.kind == "state" and own.read.kind == "next" and a.read.number == own.read.number
        ]
        if not before:
            self.trouble.add(e09_pomdpx.misplaced_persistent(place_of(element, self.trouble)))
            return
        box = self._box(target, given)
        if own.name in given:
            if box[before[0]] in (None, given[own.name]):
                box[before[0]] = given[own.name]
                self._write(target, box, element, lambda _: 1.0)
            return
        strides = [int(n == before[0]) for n in range(len(box))]
        self._write(target, box, element, lambda _: 1.0, strides, diagonal=True)


def _row(node: Any, size: int) -> Row:
    """Return what a node of a child gives its values, zeros included."""
    given = node.parts
    if node.rest is not None and len(given) < size:
        given = {**dict.fromkeys(range(size), node.rest), **given}
    return tuple(sorted(given.items()))
