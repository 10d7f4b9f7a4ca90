# SPDX-License-Identifier: Apache-2.0
"""What guides show is what the commands print; HYPGEN_UPDATE=1 writes it anew."""

import os
import re
from pathlib import Path

import pytest
from support.console import output

ROOT = Path(__file__).parent.parent.parent
BLOCK = re.compile(r"```console\n\$ (.*)\n(?:[^`].*\n|\n)*```\n")
MODEL = re.compile(r"```pomdp (\S+)\n(.*?)```\n", re.DOTALL)
SECONDS = re.compile(r"\d+\.\d\d to ")  # of a machine: the page keeps its own
PROGRESS = re.compile(r"^[\w' ]+: (?:compiling \(.*\)|cached)\n", re.MULTILINE)


@pytest.mark.parametrize(
    ("page", "shown_at_least"),
    [
        ("tools.md", 6),
        pytest.param("checking.md", 3, marks=pytest.mark.cxx),
        pytest.param("exact.md", 2, marks=pytest.mark.cxx),
    ],
)
def test_the_page_shows_what_is_printed(page: str, shown_at_least: int, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    path = ROOT / "docs" / "guide" / page
    text = path.read_text()
    for name, model in MODEL.findall(text):
        (tmp_path / name).write_text(model)

    def run(block: re.Match[str]) -> str:
        printed = PROGRESS.sub("", output(block[1], tmp_path)).rstrip("\n")
        times = iter(SECONDS.findall(block[0]))
        printed = SECONDS.sub(lambda found: next(times, found[0]), printed)
        return f"```console\n$ {block[1]}\n{printed}\n```\n"

    shown = BLOCK.sub(run, text)
    if os.environ.get("HYPGEN_UPDATE") == "1":
        path.write_text(shown)
    assert shown.count("```console") >= shown_at_least
    assert path.read_text() == shown
