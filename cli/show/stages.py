# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen explain --stage`` prints of one pass of the compiler."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping

import click

from hypgen.cli.show.node_dump import dump
from hypgen.dsl.check.passes import Draft, Whole, Written
from hypgen.dsl.check.scope.symbols import Symbols, kind_of
from hypgen.dsl.syntax import ast


class StagePrinter:
    """Looks on while a model is compiled, and prints what the pass called ``stage`` makes of it."""

    def __init__(self, stage: str) -> None:
        self._stage = stage
        self._before: object = None
        self.done = False

    def __call__(self, name: str, given: object) -> None:
        """Print what the pass ``name`` gave, if it is the one that is asked for."""
        if name == self._stage:
            click.echo(shown(self._before, given))
            self.done = True
        self._before = given


def shown(before: object, given: object) -> str:
    """Return what a pass gave, as text: of a state that passes hand on, what ``before`` did not have."""
    if isinstance(given, Mapping):
        return print_files(given)
    if isinstance(given, Written):
        before = dataclasses.replace(given, file=given.original)
    elif not isinstance(given, Draft | Whole):
        return dump(given)
    news = [dump(value, f"{name}: ") for name, value in _news(before, given)]
    return "\n".join(news) or "This pass changes nothing here."


def print_files(files: Mapping[str, str]) -> str:
    """Return the text of generated files, each under its name."""
    return "\n".join(f"// {name}\n\n{text}" for name, text in sorted(files.items())).rstrip("\n")


def _news(before: object, given: object, inside: bool = False) -> Iterator[tuple[str, object]]:
    """Yield the fields of a state that ``before`` did not have, and those of its parts that have changed."""
    for field in dataclasses.fields(given):  # type: ignore[arg-type]  # the states are dataclasses
        value = getattr(given, field.name)
        old = getattr(before, field.name, field.default)
        if value is before or value == old:
            continue
        if isinstance(value, Symbols):
            yield field.name, dict(_names(value))
        elif type(value) is type(old) and dataclasses.is_dataclass(value) and not inside:
            yield from _news(old, value, inside=True)
        elif dataclasses.is_dataclass(value) or isinstance(value, bool | int | float | str | tuple | Mapping):
            yield field.name, value


def _names(symbols: Symbols) -> Iterator[tuple[str, str]]:
    """Yield every declared name with what it is."""
    for item in symbols.declared:
        yield item.name, kind_of(item)
        members = symbols.members[item.name] if isinstance(item, ast.Element) else {}
        yield from ((f"{item.name}.{own}", kind_of(member)) for own, member in members.items())
    for name, enums in symbols.variants.items():
        yield name, f"a variant of {' and of '.join(e.name for e in enums)}"
    yield from ((name, "an observation") for name in symbols.observations)
    yield from ((name, f"{kind_of(item)} of the policy") for name, item in symbols.policy.items())
