"""The index of diagnostic codes: what each means, with an example and how to correct it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources

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
    """What a code means; ``right`` is ``wrong`` with the mistake corrected, None if it is not the model's."""

    code: str
    meaning: str
    wrong: Example
    right: Example | None


def entries() -> dict[str, Entry]:
    """Return every entry by its code, in the order of codes."""
    found: dict[str, Entry] = {}
    for file in resources.files("hypgen.cli.show").joinpath("errors").iterdir():
        for code, table in tomllib.loads(file.read_text(encoding="utf-8")).items():
            right = _example(table, "right_") if "right" in table else None
            found[code] = Entry(code, table["means"], _example(table, ""), right)
    return dict(sorted(found.items(), key=lambda item: ("EWC".index(item[0][0]), item[0])))


def _example(table: Mapping[str, object], prefix: str) -> Example:
    text = str(table["right" if prefix else "wrong"])
    files, options = table.get("files", {}), table.get("options", [])
    assert isinstance(files, dict) and isinstance(options, list)
    other_files, other_options = table.get(f"{prefix}files", {}), table.get(f"{prefix}options", options)
    assert isinstance(other_files, dict) and isinstance(other_options, list)
    starts = re.match(r"(model|instance|library)\b", text) is not None
    is_complete = bool(table.get("complete")) or starts
    return Example(text, files | other_files, tuple(other_options), is_complete)
