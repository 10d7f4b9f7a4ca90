# SPDX-License-Identifier: Apache-2.0
"""The corpus of wrong models: what each diagnostic code means, with examples and what is said of them.

``errors/*.toml`` has one entry for each code. It feeds ``hypgen error``, the pages of the documentation and
the tests. ``errors/cases/*.toml`` has more wrong models of the same codes, which only tests read.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Any

# What an example goes on with; an item that the example declares itself is left out.
BEGINNING = """\
type Cell = 0 .. 9
enum Door { left, right }
enum Act { wait, listen, open(Door) }
action act: Act
discount 0.9
horizon 20
element room {
  visible x: Cell
  hidden door: Door
  let lucky ~ bernoulli(0.5)
  init x = 0
  init door ~ uniform(Door)
  x' ~ if lucky then clamp(x + 1) else x
  door' = door
  observe heard: Door ~ noisy(door', 0.8)
}
"""

FOLDER = resources.files("hypgen.cli.show").joinpath("errors")
CASES = FOLDER.joinpath("cases")
_ITEM = re.compile(r"^(?:type|enum|element) \w+|^(?:action|discount|horizon)\b", re.MULTILINE)


@dataclass(frozen=True)
class Example:
    """A file ``example.pomdp``, other files beside it by name, and the options of ``hypgen check``."""

    text: str
    files: Mapping[str, str]
    options: tuple[str, ...]
    is_complete: bool

    def source(self) -> str:
        """Return the whole file's text; the example starts in its second line, unless it is complete."""
        if self.is_complete:
            return self.text
        declared = set(_ITEM.findall(self.text))
        items = re.split(r"\n(?! |\})", BEGINNING)
        kept = [item for item in items if (found := _ITEM.match(item)) and found.group() not in declared]
        return f"model Example\n{self.text}\n" + "\n".join(kept) + "\n"

    def named_files(self) -> dict[str, str]:
        """Return those of the files that something of the example names."""
        naming = [self.text, *self.options, *self.files.values()]
        return {name: text for name, text in self.files.items() if any(name in other for other in naming)}


@dataclass(frozen=True)
class Entry:
    """What a code means; ``right`` is ``wrong`` with the mistake corrected, None if it is not the model's.

    ``says`` is what is printed of ``wrong``.
    """

    code: str
    meaning: str
    wrong: Example
    right: Example | None
    says: str


@dataclass(frozen=True)
class Case:
    """A wrong file: its code (or ``several``), what is wrong, and what is printed of it."""

    code: str
    what: str
    name: str
    text: str
    says: str


def entries() -> dict[str, Entry]:
    """Return every entry by its code, in the order of codes."""
    found: dict[str, Entry] = {}
    for table in _tables(FOLDER):
        for code, values in table.items():
            right = _example(values, "right_") if "right" in values else None
            found[code] = Entry(code, values["means"], _example(values, ""), right, values["says"])
    return dict(sorted(found.items(), key=lambda item: ("EWC".index(item[0][0]), item[0])))


def cases() -> list[Case]:
    """Return the wrong files that are no entry's example.

    A case is a whole file, or an edit of a right one, which ``base`` names: ``old`` becomes ``new``, and
    ``more_old`` becomes ``more_new`` if the case has these.
    """
    return [
        Case(code, values["what"], *_wrong_file(values), values["says"])
        for table in _tables(CASES)
        for code, array in table.items()
        for values in array
    ]


def _tables(folder: Traversable) -> Iterator[dict[str, Any]]:
    """Yield what the TOML files of a folder hold, in the order of their names."""
    for file in sorted(folder.iterdir(), key=lambda file: file.name):
        if file.name.endswith(".toml"):
            yield tomllib.loads(file.read_text(encoding="utf-8"))


def _wrong_file(values: Mapping[str, str]) -> tuple[str, str]:
    """Return the name and the text of a case's file."""
    if "base" not in values:
        return "example.pomdp", values["wrong"]
    text = CASES.joinpath(values["base"]).read_text(encoding="utf-8")
    for prefix in ("", "more_"):
        if f"{prefix}old" in values:
            old = values[f"{prefix}old"]
            if old not in text:
                raise ValueError(f"{values['what']}: {values['base']} has no {old!r}")
            text = text.replace(old, values[f"{prefix}new"], 1)
    return values["base"], text


def _example(table: Mapping[str, object], prefix: str) -> Example:
    text = str(table["right" if prefix else "wrong"])
    files, options = table.get("files", {}), table.get("options", [])
    assert isinstance(files, dict) and isinstance(options, list)
    other_files, other_options = table.get(f"{prefix}files", {}), table.get(f"{prefix}options", options)
    assert isinstance(other_files, dict) and isinstance(other_options, list)
    starts = re.match(r"(model|instance|library)\b", text) is not None
    is_complete = bool(table.get("complete")) or starts
    return Example(text, files | other_files, tuple(other_options), is_complete)
