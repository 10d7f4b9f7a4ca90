# SPDX-License-Identifier: Apache-2.0
"""The types of random models, and what their expressions may read."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

LARGEST = 40  # a record that arrays and loops run over


@dataclass(frozen=True)
class Sort:
    """A type by its name in the model; ``parts`` are an enum's variants or a record's fields."""

    text: str
    kind: str  # bool, int, float, prob, enum, record
    low: int = 0
    high: int = 0
    parts: tuple[tuple[str, Sort | None], ...] = ()

    @property
    def finite(self) -> bool:
        """Return whether values of the type can be counted."""
        return self.kind not in ("float", "prob") and all(p is None or p.finite for _, p in self.parts)

    @property
    def size(self) -> int:
        """Return the number of values of a finite type."""
        sizes = [1 if part is None else part.size for _, part in self.parts]
        match self.kind:
            case "enum":
                return sum(sizes)
            case "record":
                return math.prod(sizes)
        return 2 if self.kind == "bool" else self.high - self.low + 1

    @property
    def plain(self) -> str:
        """Return the simplest value."""
        match self.kind:
            case "bool":
                return "false"
            case "int":
                return str(max(self.low, min(self.high, 0)))
            case "float" | "prob":
                return "0.5"
            case "enum":
                name, argument = self.parts[0]
                return name if argument is None else f"{name}({argument.plain})"
        return f"{self.text}({', '.join(p.plain for _, p in self.parts if p is not None)})"


BOOL, FLOAT, PROB = Sort("bool", "bool"), Sort("float", "float"), Sort("prob", "prob")


@dataclass(frozen=True)
class Variable:
    """A state variable or a let; of a family if ``member`` is its binder's type."""

    element: str
    member: Sort | None
    name: str
    sort: Sort
    indices: tuple[Sort, ...] = ()
    visible: bool = False
    draws: bool = False


@dataclass
class Types:
    """The types that a random model declares."""

    small: Sort
    index: Sort
    act: Sort
    mode: Sort
    pos: Sort
    vec: Sort
    declarations: list[str] = field(default_factory=list)

    @property
    def finite(self) -> tuple[Sort, ...]:
        """Return the types of variables and observations."""
        return (BOOL, self.small, self.index, self.mode, self.pos)

    @property
    def indices(self) -> tuple[Sort, ...]:
        """Return the types that index arrays and number members."""
        return (self.index, self.small, BOOL)


def declare(rng: random.Random) -> Types:
    """Return random types with the text that declares them."""
    low = rng.randint(-3, 1)
    small = Sort("Small", "int", low, low + rng.randint(2, 6))
    low = rng.randint(-1, 2)
    index = Sort("Index", "int", low, low + rng.randint(0, 3))
    act_parts: list[tuple[str, Sort | None]] = [("move", small), ("wait", None)]
    act_parts += rng.sample([("look", index), ("flip", BOOL), ("stop", None)], rng.randint(0, 2))
    rng.shuffle(act_parts)
    act = Sort("Act", "enum", parts=tuple(act_parts))
    mode_parts: list[tuple[str, Sort | None]] = [("idle", None), ("far", small)]
    mode_parts += rng.sample([("busy", BOOL), ("near", index), ("off", None)], rng.randint(0, 3))
    rng.shuffle(mode_parts)
    mode = Sort("Mode", "enum", parts=tuple(mode_parts))
    fields: list[tuple[str, Sort | None]] = [("row", index), ("col", small)]
    fields += rng.sample([("lit", BOOL), ("mode", mode)], rng.randint(0, 2))
    while Sort("Pos", "record", parts=tuple(fields)).size > LARGEST:
        fields.pop()
    rng.shuffle(fields)
    pos = Sort("Pos", "record", parts=tuple(fields))
    vec = Sort("Vec", "record", parts=(("x", FLOAT), ("y", FLOAT)))
    types = Types(small, index, act, mode, pos, vec)
    types.declarations = [
        *(f"type {s.text} = {s.low} .. {s.high}" for s in (small, index)),
        *(_enum(s) for s in (act, mode)),
        f"record Pos {{ {'  '.join(f'{n}: {s.text}' for n, s in fields if s is not None)} }}",
        "record Vec { x, y: float }",
    ]
    return types


def _enum(sort: Sort) -> str:
    variants = (name if argument is None else f"{name}({argument.text})" for name, argument in sort.parts)
    return f"enum {sort.text} {{ {', '.join(variants)} }}"
