# SPDX-License-Identifier: Apache-2.0
"""What the small forms and draws within draws save: models before and after, in lines and words.

``python benchmarks/forms.py`` writes docs/results/forms.md from the pairs in forms/before and forms/after.
"""

from __future__ import annotations

import difflib
from pathlib import Path

from hypgen.cli.commands.check import summary
from hypgen.dsl.load import load
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.parse import parse_concrete

HERE = Path(__file__).parent / "forms"
PAGE = Path(__file__).parent.parent / "docs" / "results" / "forms.md"

HEADING = """\
# What the small forms save

Models written before and after [draws within draws](../decisions/0070-draws-within-draws.md) and
the [small forms](../decisions/0074-small-forms.md). Both texts of a pair stand in
`benchmarks/forms`, laid out by `hypgen fmt`. Lines are those with code. Words are names, numbers
and signs without comments.

- **Command**: `python benchmarks/forms.py` makes this page. A test checks both texts of each pair.
- **Equal**: both texts have the same actions and observations and were written to say the same
  laws. They draw other random numbers.

| model | lines | words | bits of state |
|---|---|---|---|
"""

ENDING = """
Who knew the older forms saves one line. The gain is larger where one draw depends on another.
`slippery_walk` kept a reading in hidden state only because a draw could not stand within another,
and its filter had to guess that reading.

## What changed

"""


def names() -> list[str]:
    """Return the names of the pairs."""
    return sorted(path.stem for path in (HERE / "before").glob("*.pomdp"))


def text(when: str, name: str) -> str:
    """Return a model's text, ``before`` or ``after``."""
    return (HERE / when / f"{name}.pomdp").read_text()


def size(model: str) -> tuple[int, int]:
    """Return how many lines of code and how many words a model has."""
    _, tokens = parse_concrete(Source("model", model))
    return len({token.line for token in tokens}), len(tokens)


def page() -> str:
    """Return docs/results/forms.md."""
    parts = [HEADING]
    for name in names():
        sizes = [size(text(when, name)) for when in ("before", "after")]
        bits = [
            summary(load(HERE / when / f"{name}.pomdp").model)["state_bits"] for when in ("before", "after")
        ]
        columns = [f"{a} to {b}" for a, b in (*zip(*sizes, strict=True), bits)]
        parts.append(f"| `{name}` | {' | '.join(columns)} |\n")
    parts.append(ENDING)
    for name in names():
        old, new = (text(when, name).splitlines() for when in ("before", "after"))
        changed = [
            line
            for line in difflib.unified_diff(old, new, n=0, lineterm="")
            if line[:2] not in ("--", "++", "@@")
        ]
        parts.append("\n".join([f"### {name}\n", "```diff", *changed, "```\n\n"]))
    return "".join(parts).rstrip("\n") + "\n"


def main() -> None:
    """Write the page."""
    PAGE.write_text(page())


if __name__ == "__main__":
    main()
