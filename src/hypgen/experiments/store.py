# SPDX-License-Identifier: Apache-2.0
"""The folder of a suite's cells: each a file of JSON lines that is whole or absent.

The first line of a file says what was played, where and with what. The solver's own lines follow. A file's
name is its cell's key, so files of another machine can be copied in.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from hypgen.experiments.cells import Cell
from hypgen.experiments.suite_values import SuiteError
from hypgen.whole_files import write_whole

_NOTE = "suite.json"


class Named(Protocol):
    """What has the name of a cell: the cell, or what is known of it in its folder."""

    @property
    def key(self) -> str:
        """The cell's name."""
        ...


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
                known = self.note().get("title")
            elif any(self.folder.iterdir()):
                raise SuiteError(
                    f"'{self.folder}' has files that are no suite's; name another folder with -o"
                )
            else:
                self.write_note({"title": title})
                known = title
        except (OSError, ValueError, AttributeError) as error:
            if isinstance(error, SuiteError):
                raise
            raise SuiteError(f"the folder '{self.folder}' cannot be used: {error}") from None
        if known != title:
            raise SuiteError(
                f"'{self.folder}' has the cells of the suite {known!r}; name another folder with -o"
            )

    def note(self) -> dict[str, Any]:
        """Return what the folder says of its suite; raise ``SuiteError`` where it is no suite's."""
        try:
            found = json.loads((self.folder / _NOTE).read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise SuiteError(
                f"'{self.folder}' is no folder of a suite: it has no {_NOTE}. "
                f"`hypgen bench SUITE.toml -o {self.folder}` plays one there"
            ) from None
        except NotADirectoryError:
            raise SuiteError(f"'{self.folder}' is no folder") from None
        except (OSError, ValueError) as error:
            raise SuiteError(f"'{self.folder / _NOTE}' cannot be read: {error}") from None
        if not isinstance(found, dict) or not isinstance(found.get("title"), str):
            raise SuiteError(f"'{self.folder / _NOTE}' is not what `hypgen bench` writes")
        return found

    def write_note(self, note: dict[str, Any]) -> None:
        """Keep what the folder says of its suite."""
        write_whole(self.folder / _NOTE, json.dumps(note, indent=1) + "\n")

    def has(self, cell: Named) -> bool:
        """Return whether a cell is played."""
        return self.path(cell).exists()

    def put(self, cell: Cell, about: dict[str, Any], lines: str) -> None:
        """Keep what a solver wrote of a cell; ``about`` says where and with what."""
        of = {"type": "cell", "key": cell.key, "task": cell.setting.task.name, "program": cell.program}
        head = {**of, "options": cell.arguments(), **about}
        write_whole(self.path(cell), f"{json.dumps(head)}\n{lines}")
        self._failed(cell).unlink(missing_ok=True)

    def fail(self, failure: Failure) -> None:
        """Keep why a cell could not be played."""
        text = {
            "cell": failure.cell.arguments(),
            "task": failure.cell.setting.task.name,
            "problem": failure.problem,
        }
        write_whole(self._failed(failure.cell), json.dumps(text) + "\n")

    def failure(self, cell: Named) -> str:
        """Return why a cell could not be played; empty where nothing is known."""
        try:
            return str(json.loads(self._failed(cell).read_text(encoding="utf-8"))["problem"])
        except (OSError, ValueError, KeyError):
            return ""

    def forget_failures(self) -> None:
        """Let cells that failed be played again."""
        for path in self.folder.glob("*.failed"):
            path.unlink(missing_ok=True)

    def lines(self, cell: Named) -> Iterator[dict[str, Any]]:
        """Yield the lines of a played cell, its own first."""
        path = self.path(cell)
        try:
            with path.open(encoding="utf-8") as file:
                for line in file:
                    yield json.loads(line)
        except (OSError, ValueError) as error:
            raise broken(path, str(error)) from None

    def path(self, cell: Named) -> Path:
        """Return where a played cell is kept."""
        return self.folder / f"{cell.key}.jsonl"

    def _failed(self, cell: Named) -> Path:
        return self.folder / f"{cell.key}.failed"


def broken(path: Path, why: str) -> SuiteError:
    """Return what to say of a cell's file that a solver cannot have written."""
    return SuiteError(f"'{path}' is no cell ({why}); delete it, and `hypgen bench` plays it again")
