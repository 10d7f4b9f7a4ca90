# SPDX-License-Identifier: Apache-2.0
"""The one table of words and tokens, read off the grammar, and a lexer that takes any text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from lark import Lark

from hypgen.dsl.syntax.parser_tables import load_parser
from hypgen.dsl.types import builtin_names

_WORD = re.compile(r"[a-z]+")
_TYPES = ("type_name", "float_unit")
_OPERATORS = ("binary", "unary", "is_variant")


@dataclass(frozen=True)
class Words:
    """Reserved words by what they do, names that the language gives a meaning to, and patterns of tokens.

    ``declarations`` start or belong to items, ``control`` to expressions. ``patterns`` has the regular
    expressions of comments, strings, numbers and names by the grammar's own names.
    """

    declarations: tuple[str, ...]
    control: tuple[str, ...]
    operators: tuple[str, ...]
    types: tuple[str, ...]
    constants: tuple[str, ...]
    functions: tuple[str, ...]
    values: tuple[str, ...]
    symbols: tuple[str, ...]
    patterns: dict[str, str]

    @property
    def reserved(self) -> frozenset[str]:
        """Return every word that cannot be a name."""
        return frozenset((*self.declarations, *self.control, *self.operators, *self.types, *self.constants))


@dataclass(frozen=True)
class Lexeme:
    """A token: its kind (a field of ``Words``, a pattern's name or ``OTHER``), offset and text."""

    kind: str
    start: int
    text: str

    @property
    def end(self) -> int:
        """Return the offset behind the token."""
        return self.start + len(self.text)


@cache
def words() -> Words:
    """Return the table of the package's grammar."""
    parser = load_parser()
    fixed = {t.name: t.pattern.value for t in parser.terminals if t.pattern.type == "str"}
    reserved = {name: text for name, text in fixed.items() if _WORD.fullmatch(text)}
    origins = _reachable(parser, "expr")
    by: dict[str, str] = {}
    for rule in parser.rules:
        label = rule.alias or rule.origin.name
        for symbol in rule.expansion:
            word = reserved.get(symbol.name)
            if word is None:
                continue
            if label in _TYPES:
                kind = "types"
            elif rule.alias in _OPERATORS or rule.origin.name == "binder":
                kind = "operators"
            elif label in ("boolean", "boolean_pattern"):
                kind = "constants"
            else:
                kind = "control" if rule.origin.name in origins else "declarations"
            by[word] = min(by.get(word, kind), kind, key=_RANK.index)
    patterns = {t.name: t.pattern.value for t in parser.terminals if t.pattern.type == "re"}
    kinds = {kind: tuple(sorted(w for w, k in by.items() if k == kind)) for kind in _RANK}
    return Words(
        **kinds,
        functions=tuple(sorted(builtin_names.RESERVED_CALLS)),
        values=tuple(sorted(builtin_names.RESERVED_VALUES)),
        symbols=tuple(sorted(set(fixed.values()) - set(reserved.values()), key=lambda s: (-len(s), s))),
        patterns={n: patterns[n] for n in ("COMMENT", "STRING", "FLOAT", "INT", "NAME")},
    )


_RANK = ("types", "constants", "operators", "control", "declarations")


def _reachable(parser: Lark, start: str) -> set[str]:
    """Return the rules that an expression is made of."""
    found, pending = {start}, [start]
    while pending:
        name = pending.pop()
        for rule in parser.rules:
            if rule.origin.name == name:
                new = {s.name for s in rule.expansion if not s.is_term} - found
                found |= new
                pending += new
    return found


@cache
def _lexer() -> tuple[re.Pattern[str], dict[str, str]]:
    table = words()
    named = [f"(?P<{name}>{pattern})" for name, pattern in table.patterns.items()]
    symbols = "|".join(map(re.escape, table.symbols))
    kinds = ("declarations", "control", "operators", "types", "constants", "functions", "values")
    return re.compile("|".join((*named, f"(?P<symbols>{symbols})", r"(?P<OTHER>\S)"))), {
        word: kind for kind in reversed(kinds) for word in getattr(table, kind)
    }


def lexemes(text: str) -> Iterator[Lexeme]:
    """Yield the tokens of any text, comments among them; what is no token is ``OTHER``."""
    pattern, kinds = _lexer()
    for match in pattern.finditer(text):
        kind = str(match.lastgroup)
        yield Lexeme(kinds.get(match[0], kind) if kind == "NAME" else kind, match.start(), match[0])
