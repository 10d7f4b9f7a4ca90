# SPDX-License-Identifier: Apache-2.0
"""The folder of a suite's cells: each a file of JSON lines that is whole or absent.

The first line of a file says what was played, where and with what. The solver's own lines follow. A file's
name is its cell's key, so files of another machine can be copied in.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypgen.experiments.cells import Cell
from hypgen.experiments.suite import SuiteError

_NOTE = "suite.json"


@dataclass(frozen=True)
class Failure:
    """A cell that was not played to its end, and why."""

    cell: Cell
    problem: str


class Store:
    """A folder with the cells of one suite."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def open(self, title: str) -> None:
        """Make the folder if need be; refuse one that has something else in it."""
        note = self.folder / _NOTE
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if note.exists():
                known = json.loads(note.read_text(encoding="utf-8")).get("title")
            elif any(self.folder.iterdir()):
                raise SuiteError(
                    f"'{self.folder}' has files that are no suite's; name another folder with -o"
                )
            else:
                write_whole(note, json.dumps({"title": title}) + "\n")
                known = title
        except (OSError, ValueError, AttributeError) as error:
            if isinstance(error, SuiteError):
                raise
            raise SuiteError(f"the folder '{self.folder}' cannot be used: {error}") from None
        if known != title:
            raise SuiteError(
                f"'{self.folder}' has the cells of the suite {known!r}; name another folder with -o"
            )

    def has(self, cell: Cell) -> bool:
        """Return whether a cell is played."""
        return self._path(cell).exists()

    def put(self, cell: Cell, about: dict[str, Any], lines: str) -> None:
        """Keep what a solver wrote of a cell; ``about`` says where and with what."""
        of = {"type": "cell", "key": cell.key, "task": cell.setting.task.name, "program": cell.program}
        head = {**of, "options": cell.arguments(), **about}
        write_whole(self._path(cell), f"{json.dumps(head)}\n{lines}")
        self._failed(cell).unlink(missing_ok=True)

    def fail(self, failure: Failure) -> None:
        """Keep why a cell could not be played."""
        text = {
            "cell": failure.cell.arguments(),
            "task": failure.cell.setting.task.name,
            "problem": failure.problem,
        }
        write_whole(self._failed(failure.cell), json.dumps(text) + "\n")

    def failure(self, cell: Cell) -> str:
        """Return why a cell could not be played; empty where nothing is known."""
        try:
            return str(json.loads(self._failed(cell).read_text(encoding="utf-8"))["problem"])
        except (OSError, ValueError, KeyError):
            return ""

    def forget_failures(self) -> None:
        """Let cells that failed be played again."""
        for path in self.folder.glob("*.failed"):
            path.unlink(missing_ok=True)

    def lines(self, cell: Cell) -> Iterator[dict[str, Any]]:
        """Yield the lines of a played cell, its own first."""
        with self._path(cell).open(encoding="utf-8") as file:
            for line in file:
                yield json.loads(line)

    def scratch(self, cell: Cell, suffix: str) -> Path:
        """Return where a process of this machine may write while it plays a cell."""
        return self.folder / f"{cell.key}.{os.getpid()}.{suffix}"

    def _path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.key}.jsonl"

    def _failed(self, cell: Cell) -> Path:
        return self.folder / f"{cell.key}.failed"


def write_whole(path: Path, text: str) -> None:
    """Write a file beside its place, and rename it once it is on the disk."""
    beside = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        with beside.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
