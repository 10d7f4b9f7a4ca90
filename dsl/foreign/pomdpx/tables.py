"""The parameters of POMDPX: tables of entries, and decision diagrams."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

from hypgen.dsl.foreign.pomdpx.xml_tree import Element
from hypgen.dsl.foreign.tables.foreign_model import Read, count, position
from hypgen.dsl.foreign.tables.rows import TOLERANCE
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages.diagnostic import did_you_mean

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

    def __init__(self, trouble: Trouble) -> None:
        self.trouble = trouble

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
            sizes = " x ".join(str(a.size) for a in parents)
            message = f"a table of {sizes} rows is larger than {MAX_ROWS}"
            remedy = "make the model smaller, or split the variables"
            raise self.trouble.stop("E0912", message, element.start, 10, remedy)
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
                self._add("E0911", "<Parameter> of type DD lacks <DAG>", element, "add it")
            else:
                self._inside(dag, target, {}, 0)
        else:
            self._add("E0911", f"a <Parameter> has the type '{kind[:20]}'", element, "give it TBL or DD")
        return len(self.trouble.found) == before

    def _add(self, code: str, message: str, element: Element, remedy: str) -> None:
        self.trouble.add(code, message, element.start, len(element.tag) + 1, remedy)

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
            remedy = "write each entry once"
            message = "entries are written again and again, millions of them"
            raise self.trouble.stop("E0912", message, element.start, len(element.tag) + 1, remedy)
        return product(*ranges)

    # Tables of entries ---------------------------------------------------------------------------

    def _entry(self, entry: Element, target: _Target, tag: str) -> None:
        instance, numbers = entry.child("Instance"), entry.child(tag)
        if instance is None or numbers is None:
            lacks = f"<{tag}>" if instance is not None else "<Instance>"
            self._add("E0911", f"<Entry> lacks {lacks}", entry, f"give it <Instance> and <{tag}>")
            return
        words = instance.text.split()
        if len(words) != len(target.axes):
            message = f"<Instance> names {len(words)} values, and there are {len(target.axes)} variables"
            remedy = f"name one of each: {' '.join(a.name for a in target.axes)}"
            self.trouble.add("E0903", message, instance.text_start, len(instance.text), remedy)
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
        remedy = did_you_mean(word, axis.names) or f"its values are {', '.join(axis.names[:5])}"
        message = f"'{axis.name}' has no value '{word[:30]}'"
        self.trouble.add("E0902", message, place.text_start, len(place.text.split("\n")[0]), remedy)
        return None

    def _numbers(
        self, element: Element, target: _Target, sizes: list[int], listed: list[int]
    ) -> list[float] | None:
        """Return the numbers of an entry, one for each combination of the values marked ``-``."""
        text, size = element.text, count(sizes)
        if text == "identity":
            self._add("E0903", "'identity' needs two '-' of like variables", element, "give the numbers")
            return None
        if size > MAX_WRITTEN:
            self._add("E0912", f"an entry stands for more than {MAX_WRITTEN}", element, "write them apart")
            return None
        if text == "uniform":
            last = target.axes[-1].size
            return [1.0 / last] * size
        words = text.split()
        if len(words) != size:
            message = f"<{element.tag}> has {len(words)} numbers and takes {size}"
            self._add("E0903", message, element, "give one for each combination of the values marked '-'")
            return None
        values = [self.number(w) for w in words]
        for word, value in zip(words, values, strict=True):
            if value is None or (target.rows is not None and not 0 <= value <= 1 + TOLERANCE):
                self._no_number(word, element, target)
                return None
        return [v for v in values if v is not None]

    def _no_number(self, word: str, element: Element, target: _Target) -> None:
        what = "probability" if target.rows is not None else "number"
        message = f"'{word[:30]}' is no {what}"
        remedy = "give one from 0 to 1" if what == "probability" else "correct it"
        self.trouble.add("E0906", message, element.text_start, 1, remedy)

    # Decision diagrams ---------------------------------------------------------------------------

    def _inside(self, parent: Element, target: _Target, given: dict[str, Sequence[int]], depth: int) -> None:
        """Fill in what is below ``parent``, where ``given`` holds."""
        if depth > _MOST_NESTED:
            remedy = "a template may not lead to itself"
            raise self.trouble.stop("E0910", "the diagram is nested too deep", parent.start, 4, remedy)
        for element in parent.children:
            if element.tag == "Node":
                self._node(element, target, given, depth)
            elif element.tag == "Terminal":
                self._terminal(element, target, given)
            elif element.tag == "SubDAG":
                self._sub_dag(element, target, given, depth)
            else:
                self._add(
                    "E0911", f"<{element.tag}> cannot stand here", element, "use Node, Terminal or SubDAG"
                )

    def _axis(self, element: Element, target: _Target) -> Axis | None:
        name = element.attributes.get("var", "")
        for axis in target.axes:
            if axis.name == name:
                return axis
        remedy = did_you_mean(name, [a.name for a in target.axes]) or "name it in <Parent>"
        self._add("E0902", f"'{name[:30]}' is no variable of this table", element, remedy)
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
        if value is None or (target.rows is not None and not 0 <= value <= 1 + TOLERANCE):
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
                self._add(
                    "E0902", "there is no template of this name", element, "add <SubDAGTemplate> with it"
                )
            else:
                self._inside(template, target, given, depth + 1)
        elif kind not in ("deterministic", "persistent", "uniform") or target.rows is None:
            self._add(
                "E0911", f"a <SubDAG> of type '{kind[:20]}' cannot stand here", element, "correct its type"
            )
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
            self._add(
                "E0911", "'persistent' needs the variable before the step as a parent", element, "name it"
            )
            return
        for at in self._write(target, self._ranges(target, given), element):
            if at[-1] == at[before[0]]:
                self._set(target, at, 1.0)
