# SPDX-License-Identifier: Apache-2.0
"""docs/guide/tutorial.md, from top to bottom: its model grows, and its commands print what it shows.

``HYPGEN_UPDATE=1 pytest tests/e2e/test_tutorial.py`` writes the page anew; review the difference.
"""

import os
import re
from pathlib import Path

from support.console import output

PAGE = Path(__file__).parent.parent.parent / "docs" / "guide" / "tutorial.md"
PART = re.compile(r"```(pomdp|pomdp-part) (\S+)\n(.*?)```\n|```console\n\$ ([^\n]*)\n.*?```\n", re.DOTALL)


def test_the_tutorial_shows_what_happens(tmp_path: Path) -> None:
    page = PAGE.read_text()

    def follow(block: re.Match[str]) -> str:
        kind, name, text, command = block.groups()
        if command is not None:
            printed = output(command, tmp_path).rstrip("\n")
            return f"```console\n$ {command}\n{printed}\n```\n"
        before = (tmp_path / name).read_text() + "\n" if kind == "pomdp-part" else ""
        (tmp_path / name).write_text(before + text)
        return block[0]

    shown = PART.sub(follow, page)
    if os.environ.get("HYPGEN_UPDATE") == "1":
        PAGE.write_text(shown)
    assert shown.count("```console") >= 8
    assert PAGE.read_text() == shown
