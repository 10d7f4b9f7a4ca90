# SPDX-License-Identifier: Apache-2.0
"""The observation key in C++: how its digits are written, read and shown.

A key of one word is plain arithmetic, its first digit the most significant. A longer one goes through the
runtime's ``KeyWriter`` and ``KeyReader``, which know where a word is full.
"""

from __future__ import annotations

from collections.abc import Set

from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import Expr, call, cast, method, of, shifted
from hypgen.codegen.tree.statements import Declare, Do, For, Return, assign, for_below, for_down, var
from hypgen.dsl import ir
from hypgen.dsl.ir import key_digits
from hypgen.dsl.types import length_of, low_of


class KeyLayout:
    """The text for one model's keys."""

    def __init__(self, fields: tuple[ir.KeyField, ...]) -> None:
        self.fields = fields
        self.wide = key_digits.is_wide(fields)

    @property
    def type(self) -> str:
        """Return the C++ type that ``Key`` stands for."""
        return f"WideKey<{key_digits.word_count(self.fields)}>" if self.wide else "std::uint64_t"

    @property
    def argument(self) -> str:
        """Return how a function takes a key."""
        return "const Key&" if self.wide else "Key"

    def begin(self, code: Code) -> None:
        """Append the start of a key that digits are put into."""
        code.add(Declare("KeyWriter<Key>", "key") if self.wide else var("Key", "key", 0))

    def put(self, code: Code, field: ir.KeyField, digit: Expr) -> None:
        """Append a digit of ``field``; ``digit`` counts from 0."""
        if self.wide:
            code.add(Do(method("key", "put", cast("std::uint64_t", digit), field.size)))
        else:
            code.add(assign("key", of("key") * field.size + cast("Key", digit)))

    def end(self, code: Code) -> None:
        """Append the return of the whole key."""
        code.add(Return(method("key", "key") if self.wide else of("key")))

    def reading(self) -> tuple[ir.KeyField, ...]:
        """Return the fields in the order in which digits are taken from a key."""
        return self.fields if self.wide else self.fields[::-1]

    def reading_of(self, used: Set[str] | None) -> tuple[ir.KeyField, ...]:
        """Return the fields that are taken or passed over until the last of ``used``, or all."""
        found = self.reading()
        while used is not None and found and found[-1].name not in used:
            found = found[:-1]
        return found

    def begin_reading(self, code: Code) -> None:
        """Append what digits are then taken from."""
        if not self.fields:
            return
        if self.wide:
            code.add(Declare("KeyReader", "rest", arguments=(call("words_of", "key"),)))
        else:
            code.add(var("Key", "rest", "key"))

    def entries(self, field: ir.KeyField) -> For:
        """Return a loop over the field's entries ``i`` in the order in which they are taken."""
        length = length_of(field.indices)
        return for_below("i", length, "int") if self.wide else for_down("i", length)

    def take(self, field: ir.KeyField) -> Expr:
        """Return the next value of the field."""
        digit = method("rest", "take", field.size) if self.wide else of("rest") % field.size
        return shifted(cast("std::int32_t", digit), low_of(field.type))

    def go_on(self, code: Code, field: ir.KeyField) -> None:
        """Append what leaves the value behind that was taken."""
        if not self.wide:
            code.add(assign("rest", field.size, "/="))

    def skip(self, code: Code, field: ir.KeyField) -> None:
        """Append what passes over the next value of the field."""
        if self.wide:
            code.add(Do(method("rest", "take", field.size)))
        else:
            self.go_on(code, field)
