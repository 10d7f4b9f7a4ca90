# SPDX-License-Identifier: Apache-2.0
"""Places of variables: bit fields in 32-bit words, ``fixed`` variables apart from the rest.

An element starts on a word of its own, and so do its variables of each stage that several threads may
share: no two elements ever write the same word, and none writes a word that others read primed in that stage.
A field never crosses a word (array fields are a power of two wide, and a float takes a word of its own); what
is left over stays zero, so that equal states have equal bytes.

Members of a family whose entries share a word cannot be taken by different threads. Where a family has a
variable that takes a word for each member, narrow ones therefore share further words for each member.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from hypgen.codegen.layout import history_layout
from hypgen.dsl import ir
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Type, digits_of, length_of, low_of

WORD = 32


@dataclass(frozen=True)
class Field:
    """A variable's bits: entry i starts at bit ``shift + i * stride`` counted from the start of ``word``."""

    variable: str
    element: str
    type: Type
    indices: tuple[Type, ...]
    word: int
    shift: int
    width: int
    spread: bool = False  # a word for each entry, although narrow

    @property
    def stride(self) -> int:
        """Return the number of bits from one entry to the next."""
        return WORD if self.spread else self.width

    @property
    def length(self) -> int:
        """Return the number of entries."""
        return length_of(self.indices)

    @property
    def low(self) -> int:
        """Return the value that is stored as 0."""
        return low_of(self.type)

    @property
    def one_word(self) -> bool:
        """Return whether all entries lie in one word."""
        return self.shift + (self.length - 1) * self.stride + self.width <= WORD

    def words(self, first: int, count: int) -> range:
        """Return the words that hold ``count`` entries from ``first`` on."""
        if self.width * count == 0:
            return range(0)
        start = self.word * WORD + self.shift + first * self.stride
        return range(start // WORD, (start + (count - 1) * self.stride + self.width - 1) // WORD + 1)


@dataclass(frozen=True)
class Block:
    """``Fixed`` or ``State``: its fields and how many words they take."""

    fields: tuple[Field, ...]
    words: int


@dataclass(frozen=True)
class Layout:
    """The packing of a model's variables, and of what the history keeps (by key)."""

    fixed: Block
    state: Block
    history: Block


def pack(model: ir.Model) -> Layout:
    """Assign every variable its bits."""
    stages = _shared_stages(model)
    families = frozenset(element.name for element in model.elements if element.binder is not None)
    return Layout(
        _pack([v for v in model.variables if v.fixed], stages),
        _pack([v for v in model.variables if not v.fixed], stages, families),
        _pack([_kept(k, model.action.span) for k in history_layout.fields(model)], {}),
    )


def _shared_stages(model: ir.Model) -> dict[str, int]:
    """Return the stage in which each variable is written; 0 where a scalar element is the whole stage too."""
    families = {element.name for element in model.elements if element.binder is not None}
    result: dict[str, int] = {}
    for number, stage in enumerate(model.stages()):
        written = {assign.variable for assign in stage}
        elements = {variable.element for variable in model.variables if variable.name in written}
        shared = len(elements) > 1 or bool(elements & families)
        result |= dict.fromkeys(written, number if shared else 0)
    return result


def _kept(field: history_layout.KeptField, span: Span) -> ir.Variable:
    """Return a field of the history as a variable: they are packed alike."""
    return ir.Variable(field.key, "history", field.type, field.indices, True, False, span)


def _pack(variables: list[ir.Variable], stages: Mapping[str, int], families: Set[str] = frozenset()) -> Block:
    fields: list[Field] = []
    neighbours: dict[tuple[str, int], list[ir.Variable]] = {}
    owners = list(dict.fromkeys(v.element for v in variables))
    for variable in sorted(variables, key=lambda v: (owners.index(v.element), stages.get(v.name, 0))):
        neighbours.setdefault((variable.element, stages.get(variable.name, 0)), []).append(variable)
    bit = 0
    for (owner, _), group in neighbours.items():
        bit = _round_up(bit, WORD)
        narrow = _narrow(group) if owner in families else []
        for variable in group:
            if variable in narrow:
                continue
            width = _width(variable)
            total = width * length_of(variable.indices)
            if variable.indices and width:
                bit = _round_up(bit, width)
            if bit % WORD + total > WORD:
                bit = _round_up(bit, WORD)
            word, shift = divmod(bit, WORD)
            fields.append(Field(variable.name, owner, variable.type, variable.indices, word, shift, width))
            bit += total
        spread = _spread(narrow, _round_up(bit, WORD) // WORD)
        fields += spread
        bit = max([bit, *(WORD * (field.word + field.length) for field in spread)])
    # A struct needs a word; a field of width 0 at the very end still names one.
    return Block(tuple(fields), max(1, _round_up(bit, WORD) // WORD, *(f.word + 1 for f in fields), 1))


def _narrow(group: list[ir.Variable]) -> list[ir.Variable]:
    """Return a family's variables that would tie its members together, if another takes a word for each."""
    single = [v for v in group if len(v.indices) == 1 and _width(v)]
    narrow = [v for v in single if _width(v) < WORD]
    return narrow if len(narrow) < len(single) else []


def _spread(variables: list[ir.Variable], word: int) -> list[Field]:
    """Return the fields of variables that share words for each member, from ``word`` on."""
    fields: list[Field] = []
    shift = 0
    for variable in variables:
        width = _bits(variable)
        if shift + width > WORD:
            word, shift = word + length_of(variable.indices), 0
        fields.append(
            Field(variable.name, variable.element, variable.type, variable.indices, word, shift, width, True)
        )
        shift += width
    return fields


def _bits(variable: ir.Variable) -> int:
    return (digits_of(variable.type) - 1).bit_length()


def _width(variable: ir.Variable) -> int:
    bits = _bits(variable)
    if not variable.indices:
        return bits
    return 1 << (bits - 1).bit_length() if bits else 0


def _round_up(bit: int, unit: int) -> int:
    return -(-bit // unit) * unit
