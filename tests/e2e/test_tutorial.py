# SPDX-License-Identifier: Apache-2.0
"""docs/guide/tutorial.md, from top to bottom: its model grows, and its commands print what it shows.

``HYPGEN_UPDATE=1 pytest tests/e2e/test_tutorial.py`` writes the page anew; review the difference.
"""

import os
import re
import subprocess
from pathlib import Path

from support.console import output

from hypgen.codegen.generate import generate_library
from hypgen.dsl.load import load
from hypgen.runtime import builder
from hypgen.runtime.builder import tools

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


def test_the_robots_program_fits_the_librarys_headers(tmp_path: Path) -> None:
    page = PAGE.read_text()
    blocks = [block for block in PART.finditer(page) if block[1]]
    model, runtime = tmp_path / "pipes.pomdp", Path(builder.__file__).parent.parent
    last = max(n for n, block in enumerate(blocks) if block[1] == "pomdp")
    model.write_text("\n".join(block[3] for block in blocks[last:]))
    header = generate_library(load(model).model)["include/pipes.h"]
    (tmp_path / "pipes.h").write_text(header)
    [text] = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    includes = "".join(f"#include <{name}>\n" for name in ("pipes.h", "stdio.h", "string.h"))
    command = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", f"-I{tmp_path}", "-x", "c", "-"]
    compiler = str(tools.find_tools().compiler.path)
    command = [compiler, f"-I{runtime / 'include'}", *command]
    done = subprocess.run(command, input=includes + text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
