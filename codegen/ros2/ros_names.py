# SPDX-License-Identifier: Apache-2.0
"""Names that ROS 2 takes, from those of a model.

Packages and fields are lower case, messages CamelCase, constants upper case. None begins with a digit, ends
with an underscore or has two in a row. Words of C++ and of Python are no fields, as code of both is made.
"""

from __future__ import annotations

import keyword
import re
from dataclasses import dataclass, field

from hypgen.codegen.layout.naming import KEYWORDS, snake_case

# Of C, and members of what Python makes of a message.
_NO_FIELDS = KEYWORDS | set(keyword.kwlist) | {"restrict", "get_fields_and_field_types"}
# Of C, C++ and Windows.
_MACROS = """
    NULL EOF NAN INFINITY HUGE HUGE_VAL DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS BUFSIZ RAND_MAX TRUE FALSE
    ERROR NO_ERROR DELETE IN OUT CONST STRICT
"""
_NO_CONSTANTS = frozenset(_MACROS.split())


@dataclass
class RosScope:
    """Names taken in a message, or among the messages of a package, as fields are written."""

    taken: set[str] = field(default_factory=set)

    def field(self, name: str) -> str:
        """Return the field of a model's name and take it."""
        word = _lower(name, "value")
        return self._unique(f"{word}_value" if word in _NO_FIELDS else word)

    def constant(self, name: str) -> str:
        """Return the constant of a model's name and take it."""
        word = _lower(name, "value").upper()
        return self._unique(f"{word}_VALUE" if word in _NO_CONSTANTS else word)

    def message(self, name: str) -> str:
        """Return the message of a model's name and take it; messages of one header's name are the same."""
        words = [w[0].upper() + w[1:] for w in re.split("_+", name) if w]
        camel = "".join(words)
        if not camel or camel[0].isdigit():
            camel = f"Type{camel}"
        found, number = camel, 2
        while header(found) in self.taken:
            found, number = f"{camel}{number}", number + 1
        self.taken.add(header(found))
        return found

    def _unique(self, name: str) -> str:
        found, number = name, 2
        while found in self.taken:
            found, number = f"{name}_{number}", number + 1
        self.taken.add(found)
        return found


def header(message: str) -> str:
    """Return the name of a message's C++ header without its end."""
    return snake_case(message)


def package_stem(stem: str) -> str:
    """Return what the names of a model's packages begin with."""
    return _lower(stem, "model")


def _lower(name: str, otherwise: str) -> str:
    """Return a name in lower case; ``otherwise`` begins one without a first letter."""
    words = re.sub(r"[\W_]+", "_", snake_case(name)).strip("_")
    if words and not words[0].isdigit():
        return words
    return f"{otherwise}_{words}".rstrip("_")
