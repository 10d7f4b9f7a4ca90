# SPDX-License-Identifier: Apache-2.0
"""The observation key in C++: how its digits are written, read and shown.

A key of one word is plain arithmetic, its first digit the most significant. A longer one goes through the
runtime's ``KeyWriter`` and ``KeyReader``, which know where a word is full.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hypgen.codegen.cpp.text import Code, shifted
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
        code.add("KeyWriter<Key> key;" if self.wide else "Key key = 0;")

    def put(self, code: Code, field: ir.KeyField, digit: str) -> None:
        """Append a digit of ``field``; ``digit`` counts from 0."""
        if self.wide:
            code.add(f"key.put(static_cast<std::uint64_t>({digit}), {field.size});")
        else:
            code.add(f"key = key * {field.size} + static_cast<Key>({digit});")

    def end(self, code: Code) -> None:
        """Append the return of the whole key."""
        code.add("return key.key();" if self.wide else "return key;")

    def reading(self) -> tuple[ir.KeyField, ...]:
        """Return the fields in the order in which digits are taken from a key."""
        return self.fields if self.wide else self.fields[::-1]

    def begin_reading(self, code: Code) -> None:
        """Append what digits are then taken from."""
        if self.fields:
            code.add("KeyReader rest(words_of(key));" if self.wide else "Key rest = key;")

    @contextmanager
    def entries(self, code: Code, field: ir.KeyField) -> Iterator[None]:
        """Append a loop over the field's entries ``i`` in the order in which they are taken."""
        length = length_of(field.indices)
        forward = f"for (int i = 0; i < {length}; ++i)"
        with code.block(forward if self.wide else f"for (int i = {length - 1}; i >= 0; --i)"):
            yield

    def take(self, code: Code, field: ir.KeyField, target: str) -> None:
        """Append ``target = value;``, the next value of the field."""
        digit = f"rest.take({field.size})" if self.wide else f"rest % {field.size}"
        code.add(f"{target} = {shifted(f'static_cast<std::int32_t>({digit})', low_of(field.type))};")
        if not self.wide:
            code.add(f"rest /= {field.size};")

    def skip(self, code: Code, field: ir.KeyField) -> None:
        """Append what passes over the next value of the field."""
        code.add(f"rest.take({field.size});" if self.wide else f"rest /= {field.size};")
