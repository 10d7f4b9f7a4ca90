# SPDX-License-Identifier: Apache-2.0
"""Reads a recording episode by episode. Memory is bounded by the longest line, and not by the file."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypgen.recordings.recording import End, Header, Start, Step, end_of, header_of, step_of

VERSION = 1
_LONGEST_LINE = 1 << 28  # bytes: a file of one longer line is no recording
_START = re.compile(rb'\{"type":"start","episode":(\d+)[,}]')
_STEP = b'{"type":"step",'
_END = b'{"type":"episode",'


class RecordingError(ValueError):
    """A file that is no recording, or one that cannot be used here; the text says why and what helps."""


@dataclass(frozen=True)
class _Place:
    offset: int  # bytes
    line: int  # counted from 1


@dataclass(frozen=True)
class Recording:
    """A file of episodes. ``cut_off`` tells whether its last line is not whole: that line is not read.

    ``returns`` has the discounted return of each episode whose end is there.
    """

    path: Path
    header: Header
    cut_off: bool
    returns: Mapping[int, float]
    _places: dict[int, _Place]

    @property
    def episodes(self) -> list[int]:
        """Return the numbers of the episodes, in the order in which they were played."""
        return list(self._places)

    def read(self, episode: int) -> Iterator[Start | Step | End]:
        """Yield an episode's start, its steps, and its end if the file has it.

        An episode that the file lacks, and a line that is broken, raise ``RecordingError``.
        """
        place = self._place(episode)
        with self.path.open("rb") as file:
            file.seek(place.offset)
            for number, text in enumerate(_whole_lines(file, self.path), place.line):
                part = part_of(text, f"{self.path}:{number}")
                if part.episode != episode:
                    return
                yield part
                if isinstance(part, End):
                    return

    def steps(self, episode: int) -> int:
        """Return how many steps of an episode the file has, without taking their lines apart.

        An episode that the file lacks raises ``RecordingError``.
        """
        place = self._place(episode)
        with self.path.open("rb") as file:
            file.seek(place.offset)
            lines = itertools.islice(_whole_lines(file, self.path), 1, None)
            return sum(1 for _ in itertools.takewhile(lambda line: line.startswith(_STEP), lines))

    def _place(self, episode: int) -> _Place:
        if episode not in self._places:
            known = ", ".join(map(str, self.episodes[:10])) or "none"
            raise RecordingError(f"{self.path} has no episode {episode}; it has {known}")
        return self._places[episode]


def open_recording(path: Path, *, model_hash: str | None = None) -> Recording:
    """Return a recording whose header and places of episodes are known.

    A file that is none, that has another version or kind, or whose model has another hash than
    ``model_hash``, raises ``RecordingError``. A file that cannot be read raises ``OSError``.
    """
    places: dict[int, _Place] = {}
    returns: dict[int, float] = {}
    header: Header | None = None
    offset = 0
    with path.open("rb") as file:
        for number, line in enumerate(_whole_lines(file, path), 1):
            if header is None:
                header = header_from(line, path)
            elif (episode := started(line)) is not None:
                places[episode] = _Place(offset, number)
            elif line.startswith(_END) and isinstance(end := part_of(line, f"{path}:{number}"), End):
                returns[end.episode] = end.discounted_return
            offset += len(line)
        cut_off = file.seek(0, 2) > offset
    if header is None:
        raise RecordingError(
            f"{path} is empty or ends within its first line; --record FILE of a solver writes one"
        )
    if model_hash is not None and header.hash != model_hash:
        raise RecordingError(
            f"{path} was recorded with another model ({header.model} of {header.file}, hash "
            f"{header.hash[:12]}, and not {model_hash[:12]}); name its model, instance and settings"
        )
    return Recording(path, header, cut_off, returns, places)


def _whole_lines(file: Any, path: Path) -> Iterator[bytes]:
    """Yield lines up to one that is cut off."""
    while line := file.readline(_LONGEST_LINE):
        if not line.endswith(b"\n"):
            if len(line) == _LONGEST_LINE:
                raise RecordingError(f"{path} is no recording: it has a line of more than 256 MB")
            return
        yield line


def started(line: bytes) -> int | None:
    """Return the number of the episode that a line starts, and None for other lines."""
    start = _START.match(line)
    return None if start is None else int(start[1])


def part_of(text: bytes, place: str) -> Start | Step | End:
    """Return what a line after the header says; a broken one raises ``RecordingError`` with its place."""
    try:
        line = json.loads(text)
        if line["type"] == "start":
            return Start(line["episode"], line["visible"])
        return step_of(line) if line["type"] == "step" else end_of(line)
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError(f"{place}: this line of the recording is broken ({error!r})") from None


def header_from(text: bytes, path: Path) -> Header:
    """Return the header that the first line of ``path`` is; ``RecordingError`` where it is none."""
    none = f"{path} is no recording: its first line is not a header; --record FILE of a solver writes one"
    try:
        line = json.loads(text)
    except ValueError:
        raise RecordingError(none) from None
    if isinstance(line, dict) and line.get("type") == "run":
        raise RecordingError(f"{path} has the lines of --json; record the run with --record FILE")
    if not isinstance(line, dict) or line.get("type") != "recording":
        raise RecordingError(none)
    if line.get("version") != VERSION:
        raise RecordingError(
            f"{path} is of version {line.get('version')!r}, and this hypgen reads version {VERSION}; "
            "record it again"
        )
    if line.get("kind") != "episode":
        raise RecordingError(f"{path} is of kind {line.get('kind')!r}, and this hypgen knows only 'episode'")
    try:
        return header_of(line)
    except (KeyError, TypeError) as error:
        raise RecordingError(f"{path}: the header is broken ({error!r})") from None
