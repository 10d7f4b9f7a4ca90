# SPDX-License-Identifier: Apache-2.0
"""The parameters of POMDPX: tables of entries, and decision diagrams."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

from hypgen.dsl.foreign.pomdpx.xml_tree import Element, place_of
from hypgen.dsl.foreign.tables.foreign_model import Read, count, position
from hypgen.dsl.foreign.tables.sums import Sums
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_pomdpx

MAX_ROWS = 2_000_000
MAX_WRITTEN = 10_000_000  # entries of a table, those that are written again included
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_MOST_NESTED = 100


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


@dataclass
class _Target:
    """A table in the making: its axes, the child's the last if there is one, and where numbers go."""

    axes: list[Axis]
    rows: list[dict[int, float]] | None
    values: list[float]
    written: int = 0
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

    def law(self, element: Element, parents: list[Axis], own: Axis) -> list[dict[int, float]] | None:
        """Return the rows of a law; None after a mistake."""
        rows: list[dict[int, float]] = [{} for _ in range(self._checked(element, parents))]
        return rows if self._fill(element, _Target([*parents, own], rows, []), "ProbTable") else None

    def values(self, element: Element, parents: list[Axis]) -> list[float] | None:
        """Return the values of a function; None after a mistake."""
        target = _Target(parents, None, [0.0] * self._checked(element, parents))
        return target.values if self._fill(element, target, "ValueTable") else None

    def _checked(self, element: Element, parents: list[Axis]) -> int:
        """Return how many rows a table has."""
        size = count([a.size for a in parents])
        if size > MAX_ROWS:
            span = self.trouble.span(element.start, 10)
            raise self.trouble.stop(e09_pomdpx.many_rows([a.size for a in parents], MAX_ROWS, span))
        return size

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

    def _set(self, target: _Target, at: Sequence[int], value: float) -> None:
        sizes = [a.size for a in target.axes]
        if target.rows is None:
            target.values[position(at, sizes)] = value
        else:
            target.rows[position(at[:-1], sizes[:-1])][at[-1]] = value

    def _write(
        self, target: _Target, ranges: Sequence[Sequence[int]], element: Element
    ) -> Iterator[tuple[int, ...]]:
        """Yield the places of all combinations; there may not be too many in all."""
        target.written += count([len(r) for r in ranges])
        if target.written > MAX_WRITTEN:
            raise self.trouble.stop(e09_pomdpx.many_rewrites(place_of(element, self.trouble)))
        return product(*ranges)

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
        ranges: list[Sequence[int]] = []
        for word, axis in zip(words, target.axes, strict=True):
            found = self._value(word, axis, instance)
            if found is None:
                return
            ranges.append(found)
        listed = [n for n, word in enumerate(words) if word == "-"]
        sizes = [target.axes[n].size for n in listed]
        if (
            numbers.text == "identity"
            and target.rows is not None
            and self._identity(entry, target, ranges, listed)
        ):
            return
        values = self._numbers(numbers, target, sizes, listed)
        if values is None:
            return
        for at in self._write(target, ranges, entry):
            self._set(target, at, values[position([at[n] for n in listed], sizes)])

    def _identity(
        self, entry: Element, target: _Target, ranges: Sequence[Sequence[int]], listed: list[int]
    ) -> bool:
        """Write the rows of an identity of child and parent, which may be large; False if it is none."""
        last = len(target.axes) - 1
        if len(listed) != 2 or listed[1] != last or target.axes[listed[0]].size != target.axes[last].size:
            return False
        assert target.rows is not None
        sizes = [a.size for a in target.axes[:-1]]
        for at in self._write(target, ranges[:-1], entry):
            target.rows[position(at, sizes)] = {at[listed[0]]: 1.0}
        return True

    def _value(self, word: str, axis: Axis, place: Element) -> Sequence[int] | None:
        if word in ("*", "-"):
            return range(axis.size)
        if word in axis.names:
            return (axis.names.index(word),)
        span = self.trouble.span(place.text_start, len(place.text.split("\n")[0]))
        self.trouble.add(e09_pomdpx.unknown_value(axis.name, word, axis.names, span))
        return None

    def _numbers(
        self, element: Element, target: _Target, sizes: list[int], listed: list[int]
    ) -> list[float] | None:
        """Return the numbers of an entry, one for each combination of the values marked ``-``."""
        text, size = element.text, count(sizes)
        if text == "identity":
            self.trouble.add(e09_pomdpx.misplaced_identity(place_of(element, self.trouble)))
            return None
        if size > MAX_WRITTEN:
            self.trouble.add(e09_pomdpx.large_entry(MAX_WRITTEN, place_of(element, self.trouble)))
            return None
        if text == "uniform":
            last = target.axes[-1].size
            return [1.0 / last] * size
        words = text.split()
        if len(words) != size:
            span = place_of(element, self.trouble)
            self.trouble.add(e09_pomdpx.wrong_count(element.tag, len(words), size, span))
            return None
        values = [self.number(w) for w in words]
        for word, value in zip(words, values, strict=True):
            if value is None or (target.rows is not None and not self.sums.is_probability(value)):
                self._no_number(word, element, target)
                return None
        return [v for v in values if v is not None]

    def _no_number(self, word: str, element: Element, target: _Target) -> None:
        wrong = e09_pomdpx.no_number if target.rows is None else e09_pomdpx.no_probability
        # Comments between the words are not in the element's text; the word stands behind its start still.
        found = re.compile(rf"(?<![^\s>]){re.escape(word)}(?![^\s<])").search(
            self.trouble.source.text, element.text_start
        )
        start = found.start() if found else element.text_start
        self.trouble.add(wrong(word, self.trouble.span(start, len(word))))

    # Decision diagrams ---------------------------------------------------------------------------

    def _inside(self, parent: Element, target: _Target, given: dict[str, Sequence[int]], depth: int) -> None:
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

    def _node(self, node: Element, target: _Target, given: dict[str, Sequence[int]], depth: int) -> None:
        axis = self._axis(node, target)
        if axis is None:
            return
        for edge in node.all("Edge"):
            word = edge.attributes.get("val", "")
            values = self._value("*" if word == "*" else word, axis, edge) if word != "-" else None
            if values is None:
                continue
            known = given.get(axis.name)
            values = values if known is None else [v for v in values if v in known]
            if values:
                self._inside(edge, target, {**given, axis.name: values}, depth + 1)

    def _ranges(self, target: _Target, given: dict[str, Sequence[int]]) -> list[Sequence[int]]:
        return [given.get(a.name, range(a.size)) for a in target.axes]

    def _terminal(self, element: Element, target: _Target, given: dict[str, Sequence[int]]) -> None:
        value = self.number(element.text)
        if value is None or (target.rows is not None and not self.sums.is_probability(value)):
            self._no_number(element.text, element, target)
            return
        for at in self._write(target, self._ranges(target, given), element):
            self._set(target, at, value)

    def _sub_dag(
        self, element: Element, target: _Target, given: dict[str, Sequence[int]], depth: int
    ) -> None:
        kind = element.attributes.get("type", "")
        if kind == "template":
            template = target.templates.get(element.attributes.get("idref", ""))
            if template is None:
                self.trouble.add(e09_pomdpx.unknown_template(place_of(element, self.trouble)))
            else:
                self._inside(template, target, given, depth + 1)
        elif kind not in ("deterministic", "persistent", "uniform") or target.rows is None:
            self.trouble.add(e09_pomdpx.misplaced_sub_diagram(kind, place_of(element, self.trouble)))
        elif kind == "uniform":
            for at in self._write(target, self._ranges(target, given), element):
                self._set(target, at, 1.0 / target.axes[-1].size)
        elif kind == "deterministic":
            self._deterministic(element, target, given)
        else:
            self._persistent(element, target, given)

    def _deterministic(self, element: Element, target: _Target, given: dict[str, Sequence[int]]) -> None:
        own = target.axes[-1]
        values = self._value(element.attributes.get("val", ""), own, element)
        if values is not None:
            for at in self._write(target, self._ranges(target, {**given, own.name: values}), element):
                self._set(target, at, 1.0)

    def _persistent(self, element: Element, target: _Target, given: dict[str, Sequence[int]]) -> None:
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
        for at in self._write(target, self._ranges(target, given), element):
            if at[-1] == at[before[0]]:
                self._set(target, at, 1.0)
