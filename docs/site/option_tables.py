# SPDX-License-Identifier: Apache-2.0
"""Reads the solvers' options from the C++ tables that their ``--help`` is printed from."""

import ast
import re
from dataclasses import dataclass
from pathlib import Path

_SOURCES = Path(__file__).parents[2] / "runtime" / "src"
_SHARED = _SOURCES / "solver" / "option_table.cpp"
_TEXT = r'"(?:[^"\\]|\\.)*"'
_ROW = re.compile(
    rf'(?:\b(?P<make>integer|number|toggle|file|mebibytes)\(|\{{)\s*"(?P<name>--[a-z-]+)",\s*(?P<texts>{_TEXT}(?:[\s,]+{_TEXT})*)'
)
_HELPER = re.compile(r"^Option (\w+)\([^)]*\) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
_FIXED = {"toggle": "", "file": "FILE", "mebibytes": "MIB"}


@dataclass(frozen=True)
class SolverOption:
    """One row: ``--name``, what stands for its value (none of a switch), and the text of ``--help``."""

    name: str
    metavar: str
    help: str


def read(file: str) -> list[SolverOption]:
    """Return the table of ``file`` under runtime/src, in its order."""
    text = (_SOURCES / file).read_text(encoding="utf-8")
    start = text.index("std::vector<Option>")
    table = text[text.index("return {", start) : text.index("\n}\n", start)]
    shared = {
        name: body for name, body in _HELPER.findall(_SHARED.read_text(encoding="utf-8")) if '"--' in body
    }
    for name, body in shared.items():
        table = re.sub(rf"\b{name}\([^()]*\)", lambda _, body=body: body, table)
    rows = [_row(found) for found in _ROW.finditer(table)]
    if len(rows) != table.count('"--'):
        raise ValueError(
            f"{file}: {table.count(chr(34) + '--')} options stand there, {len(rows)} are understood"
        )
    return rows


def _row(found: re.Match[str]) -> SolverOption:
    # Texts side by side are one; a comma between them parts the metavar from the help.
    texts = [
        "".join(ast.literal_eval(part) for part in re.findall(_TEXT, group))
        for group in re.split(r"(?<=\")\s*,\s*(?=\")", found["texts"])
    ]
    make = found["make"]
    if make in _FIXED:
        return SolverOption(found["name"], _FIXED[make], texts[0])
    return SolverOption(found["name"], texts[0], texts[1])
