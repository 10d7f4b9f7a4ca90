# SPDX-License-Identifier: Apache-2.0
"""What docs/guide/tools.md shows is what the commands print; HYPGEN_UPDATE=1 writes it anew."""

import os
import re
from pathlib import Path

from support.console import output

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "guide" / "tools.md"
BLOCK = re.compile(r"```console\n\$ (.*)\n(?:[^`].*\n|\n)*```\n")


def test_the_page_shows_what_is_printed(tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    page = PAGE.read_text()

    def run(block: re.Match[str]) -> str:
        text = output(block[1], tmp_path).rstrip("\n")
        return f"```console\n$ {block[1]}\n{text}\n```\n"

    shown = BLOCK.sub(run, page)
    if os.environ.get("HYPGEN_UPDATE") == "1":
        PAGE.write_text(shown)
    assert shown.count("```console") >= 6
    assert PAGE.read_text() == shown
